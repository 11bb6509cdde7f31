"""Array shapes with an axis of lanes, for annotations, which are not checked at run time."""

from typing import Any

import numpy as np
from jaxtyping import Float, Int, Shaped

#: Values that can be converted to a number, or to a number for each lane; shape () or (lanes,).
PerRunLike = Float[Any, "*lanes"]

#: Values that can be converted to a count, or to a count for each lane; shape () or (lanes,).
CountPerRunLike = Int[Any, "*lanes"]

#: Values that can be converted to a displacement, shape () or (n,), or to a displacement for each lane, shape (lanes,)
#: or (lanes, n).
DisplacementsLike = Float[Any, "*lanes_and_n"]

#: A number, or a number for each lane; shape () or (lanes,).
PerRun = Float[np.ndarray, "*lanes"]

#: A count, or a count for each lane; shape () or (lanes,).
CountPerRun = Int[np.ndarray, "*lanes"]

#: A displacement, shape () or (n,), or a displacement for each lane, shape (lanes,) or (lanes, n).
Displacements = Float[np.ndarray, "*lanes_and_n"]

#: Displacements of all lanes of an ensemble, shape (lanes,) or (lanes, n).
DisplacementsOfLanes = Float[np.ndarray, "lanes *n"]

#: Status or step of a run, of each lane if there are lanes, shape () or (lanes,).
Flags = Int[Any, "*lanes"]

#: Values that an observer returned, of each lane if there are lanes.
Observed = Shaped[Any, "..."]
