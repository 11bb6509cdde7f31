"""The motion on which two schemes of a program agree as their steps are halved, and its uncertainty."""

import math
from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from study.program.attempt import Run
from study.program.curves import Curve, curves

#: Number of runs with halved steps from which an error is estimated: minimum and maximum.
FEWEST_RUNS, RUNS = 3, 4

#: Largest deviations from an integer order with which a quantity is extrapolated: deviation of the last observed order,
#: and of the order before it.
OFF_ORDER = (0.15, 0.4)

#: Smallest and largest order that the error estimate assumes for a quantity that is not extrapolated.
ORDERS = (0.5, 1.0)

#: Largest ratio of the difference of two schemes to their own errors; above it, they solve different problems.
APART = 10.0


class Estimate(NamedTuple):
    """The motion that one scheme gives with halved steps.

    Attributes
    ----------
    dt
        The finest step of the runs, in s.
    motion
        Quantities of the finest run, or extrapolated from the finest two.
    order
        Orders of the extrapolated quantities, by name.
    error
        Error of each quantity, relative to its size.
    """

    scheme: str
    dt: float
    motion: dict[str, Curve]
    order: dict[str, int]
    error: dict[str, float]


class Truth(NamedTuple):
    """The motion on which two schemes agree.

    Attributes
    ----------
    best, witness
        The scheme that gives the motion, and the one with which it is compared.
    uncertainty
        Uncertainty of each quantity, relative to its size: the difference of the two schemes plus the error of
        interpolation between the steps, or the larger of the two schemes' own errors if it exceeds this sum.
    """

    best: Estimate
    witness: Estimate
    uncertainty: dict[str, float]

    @property
    def apart(self) -> bool:
        """Whether the two schemes converge to different motions."""
        own = max(*self.best.error.values(), *self.witness.error.values())
        return max(self.uncertainty.values()) > APART * own

    @property
    def sizes(self) -> dict[str, float]:
        """Largest absolute value of each quantity."""
        return {name: one.size for name, one in self.best.motion.items()}

    def errors(self, run: Run) -> dict[str, float]:
        """Largest error of each quantity at any step of a run, relative to its size; NaN if the run failed."""
        if not run.completed:
            return dict.fromkeys(self.uncertainty, math.nan)
        found = curves(run)
        return {name: found[name].distance(true) / true.size for name, true in self.best.motion.items()}


def _extrapolated(coarser: Curve, finer: Curve, order: int) -> Curve:
    """Richardson's extrapolation, at the times of the coarser run."""
    shared = coarser.within(finer)
    return Curve(shared.t, shared.values - shared.difference(finer) * (1 + 1 / (2**order - 1)))


def estimate(runs: Sequence[Run]) -> Estimate | None:
    """The motion by a scheme, from its completed runs with halved steps, the finest last; None if there are too few."""
    if len(runs) < FEWEST_RUNS:
        return None
    of_runs = [curves(run) for run in runs[-RUNS:]]
    motion: dict[str, Curve] = {}
    orders: dict[str, int] = {}
    error: dict[str, float] = {}
    for name in of_runs[-1]:
        along = [one[name] for one in of_runs]
        motion[name], order, off = _limit(along)
        size = motion[name].size
        error[name] = off / size if size else math.inf
        orders |= {name: order} if order else {}
    return Estimate(runs[-1].scheme, runs[-1].dt, motion, orders, error)


def _limit(along: Sequence[Curve]) -> tuple[Curve, int, float]:
    """Limit of a quantity, the order of its extrapolation (zero without extrapolation), and the limit's uncertainty."""
    apart = [coarser.distance(finer) for coarser, finer in pairwise(along)]
    observed = [math.log2(a / b) if a > 0 and b > 0 else math.nan for a, b in pairwise(apart)]
    order = round(observed[-1]) if observed[-1] > 0.5 else 0
    near = [abs(one - order) <= off for one, off in zip(reversed(observed), OFF_ORDER, strict=False)]
    # the errors of a single number, such as a peak among steps, have no order
    if order and along[-1].values.ndim and len(near) == len(OFF_ORDER) and all(near):
        before, last = (_extrapolated(coarser, finer, order) for coarser, finer in list(pairwise(along))[-2:])
        # the whole difference, as for a remainder of first order, which motions with kinks have
        return last, order, before.distance(last)
    clipped = float(np.clip(observed[-1], *ORDERS)) if apart[-1] > 0 < apart[-2] else ORDERS[0]
    # at least half of the difference before the last one, because the last one may be small by chance
    return along[-1], 0, max(apart[-1], apart[-2] / 2) / (2**clipped - 1)


def agreed(estimates: Iterable[Estimate]) -> Truth | None:
    """The comparison of the two schemes that agree best; None if there are fewer than two schemes."""
    found = [_compared(*pair) for pair in combinations(estimates, 2)]
    return min(found, key=lambda truth: max(truth.uncertainty.values()), default=None)


def _compared(one: Estimate, other: Estimate) -> Truth:
    best, witness = sorted((one, other), key=lambda estimate: max(estimate.error.values()))
    finer, coarser = sorted((one, other), key=lambda estimate: estimate.dt)
    uncertainty = {}
    for name, motion in best.motion.items():
        apart = coarser.motion[name].distance(finer.motion[name]) + motion.between()
        own = max(one.error[name], other.error[name])
        uncertainty[name] = max(apart / motion.size, own) if motion.size else math.inf
    return Truth(best, witness, uncertainty)
