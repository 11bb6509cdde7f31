"""The observed order of convergence of errors."""

import numpy as np
from jaxtyping import Bool, Float

#: Smallest number of errors in a fit by default.
LEAST = 3

Numbers = Float[np.ndarray, " steps"]
Counted = Bool[np.ndarray, " steps"]


def observed_order(steps: Numbers, errors: Numbers, counts: Counted | None = None, least: int = LEAST) -> float:
    r"""Order p of errors :math:`e = C n^{-p}`: minus the slope of log e over log n by least squares.

    Parameters
    ----------
    steps
        Numbers of steps n, in any unit of time.
    errors
        Errors e, NaN for failed runs.
    counts
        Errors that count, by default all positive and finite errors.
    least
        Smallest number of errors in the fit.

    Returns
    -------
    float
        NaN if fewer than ``least`` errors count.
    """
    counts = (errors > 0) & np.isfinite(errors) & (True if counts is None else counts)
    if counts.sum() < least:
        return np.nan
    return float(-np.polyfit(np.log(steps[counts]), np.log(errors[counts]), 1)[0])
