"""The rule for the step size that keeps an error: every smaller one that was tried keeps it too.

Runs, searches, measures and claims share this rule. A size may also be a tolerance, or a count that falls as steps
become coarser.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from jaxtyping import Bool, Float

#: Smallest ratio of an allowed error to the uncertainty of the reference at which steps are recommended.
CERTAIN = 10.0

#: Smallest step that counts as confirming a recommended step, as a fraction of the recommended step.
TWENTIETH = 1 / 20

#: Quantile of the errors at the steps up to an octave below a step. The margin for untried steps is the largest of
#: these errors minus the quantile.
USUAL = 0.9

#: Name of a quantity, and its allowed error.
Limit = tuple[str, float]

#: Sizes, or one number for each.
Sizes = Float[np.ndarray, " size"]
Kept = Bool[np.ndarray, "..."]


def unbroken(kept: Kept) -> Kept:
    """Whether all sizes up to each one keep an error; the sizes ascend along the last axis."""
    return np.logical_and.accumulate(kept, axis=-1)


def largest_size(kept: xr.DataArray, along: str) -> xr.DataArray:
    """The largest size along a coordinate up to which all sizes keep an error; zero if the smallest does not."""
    kept = kept.sortby(along).transpose(..., along)
    return kept[along].where(kept.copy(data=unbroken(kept.values)), 0.0).max(along)


def least_number(kept: xr.DataArray, along: str) -> xr.DataArray:
    """The smallest number of steps along a coordinate from which on all larger ones keep an error; NaN if none does."""
    kept = kept.sortby(along, ascending=False).transpose(..., along)
    return kept[along].where(kept.copy(data=unbroken(kept.values))).min(along)


def fewest(error: xr.DataArray, counts: xr.DataArray, allowed: float, along: str) -> xr.DataArray:
    """Smallest count of forces or steps from which on every run along a dimension keeps an error.

    The count is NaN if the run with the largest count exceeds the error. Runs without a count are left out.
    """

    def fewest_of_runs(error: np.ndarray, counts: np.ndarray) -> float:
        kept = error <= allowed
        largest_first = np.lexsort((kept, -counts))[: np.isfinite(counts).sum()]
        return counts[largest_first][unbroken(kept[largest_first])].min(initial=np.inf)

    counts = xr.apply_ufunc(
        fewest_of_runs, error, counts.astype(float), input_core_dims=[[along], [along]], vectorize=True
    )
    return counts.where(np.isfinite(counts))


def largest_with_margin(
    size: Sizes, error: Sizes, allowed: float, from_own_start: Any = True, octave: float = 2.0
) -> float:
    r"""Largest random size that keeps an error, as all smaller ones do, with a margin for scatter; zero if none does.

    The result is the largest size h that meets the condition

    .. math::

        2 \max_{h/r < h' \le h} e(h') - Q_{0.9}\,e(h') \le e_\text{allowed}

    with the errors e(h') of the sizes h', and their quantile :math:`Q_{0.9}` over the same octave. If a size does not
    meet it, the sizes of up to one percent smaller steps are skipped.

    Parameters
    ----------
    size, error
        Size and error of each run; the error of a failed run is NaN, which counts as too large.
    allowed
        Allowed error.
    from_own_start
        Whether each run has the problem's own start. All runs must keep the error, and these alone give the margin.
    octave
        Ratio r of two sizes if one step is twice as long as the other.
    """
    below = from_own_start & (size < size[~(error <= allowed)].min(initial=np.inf))
    size, error = size[below], error[below]
    while size.size:
        largest = size.max()
        finer = error[size > largest / octave]
        if 2 * finer.max() - np.quantile(finer, USUAL) <= allowed:
            return largest
        next_ones = size < largest * octave ** np.log2(0.99)
        size, error = size[next_ones], error[next_ones]
    return 0.0


class Needed(NamedTuple):
    """What an assessment needs for an error: sizes, and the runs that confirm the recommended one.

    ``recommended`` is the size ``largest``, rounded down. ``tried`` is the number of sizes tried that confirm it, up to
    itself, and ``largest_error`` the largest error among them. If no size keeps the error, the sizes and ``tried`` are
    zero, and ``largest_error`` is NaN.
    """

    largest: float
    recommended: float
    tried: int
    largest_error: float


def needed(
    size: Sizes,
    error: Sizes,
    allowed: float,
    rounded: Callable[[float], float],
    from_own_start: Any = True,
    octave: float = 2.0,
    confirming: float = TWENTIETH,
) -> Needed:
    """What an assessment needs for an error, by :func:`largest_with_margin`.

    ``rounded`` is a function that returns the largest round size up to a size. Sizes from the problem's own start
    confirm the recommended size if they are at least the fraction ``confirming`` of it.
    """
    largest = largest_with_margin(size, error, allowed, from_own_start, octave)
    if not largest:
        return Needed(0.0, 0.0, 0, np.nan)
    recommended = rounded(largest)
    nearby = error[from_own_start & (size >= confirming * recommended) & (size <= recommended)].tolist()
    return Needed(largest, recommended, len(nearby), max(nearby, default=np.nan))
