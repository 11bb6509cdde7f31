"""What both searches for steps share: the largest step that keeps an error, and the finer steps that confirm it."""

import numpy as np
from jaxtyping import Float

#: Smallest ratio of an allowed error to the uncertainty of the reference.
CERTAIN = 10.0

#: Finer steps down to this part of a recommended step count as tried.
TWENTIETH = 1 / 20

#: Quantile of the errors up to an octave below a step. The margin for untried steps is the worst error less this
#: quantile.
USUAL = 0.9

#: Quantity and its allowed error.
Limit = tuple[str, float]

#: Pairs of a step and its error.
Steps = Float[np.ndarray, "step"]


def largest_with_margin(dt: Steps, error: Steps, allowed: float) -> float:
    r"""Largest step that keeps an error with a margin for scatter; zero if there is none.

    All given steps must keep the error without this margin. With the errors e(h) of the steps h, the condition is

    .. math::

        2 \max_{\Delta t/2 < h \le \Delta t} e(h) - Q_{0.9}\,e(h) \le e_\text{allowed}
    """
    while dt.size:
        step = dt.max()
        octave = error[dt > step / 2]
        if 2 * octave.max() - np.quantile(octave, USUAL) <= allowed:
            return step
        dt, error = dt[dt < 0.99 * step], error[dt < 0.99 * step]
    return 0.0
