"""The smallest Δt/T at which runs of each scheme fail, by kind of failure."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import families
from paper.measures.outcomes import FAILURES, accurate_up_to, first_of, near_1996, some_near_1996
from paper.products import table


def _with_problem(values: xr.DataArray) -> str:
    """The smallest value of all problems, and the first letter of its problem; a dash if the value is infinite."""
    least = values.min().item()
    return "–" if np.isinf(least) else f"{least:.2g} ({values.problem.values[int(np.argmin(values.values))][0]})"


@table(
    "First failures near the amplitudes of 1996", atlas="stability/atlas", requires={"atlas.amplitudes": some_near_1996}
)
def tabulate(atlas: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    near = near_1996(atlas)
    accurate, first = accurate_up_to(near), {title: first_of(near, name) for name, title in FAILURES.items()}
    rows = []
    for part in families(near).values():
        for name in part.scheme.values:
            up_to = accurate.sel(scheme=name)
            rows.append(
                {
                    "Scheme": part.scheme_title.sel(scheme=name).item(),
                    "1 % up to": "–" if up_to.min() == 0 else _with_problem(up_to),
                    **{title: _with_problem(values.sel(scheme=name)) for title, values in first.items()},
                }
            )
    return pd.DataFrame(rows)
