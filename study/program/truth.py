"""The motion on which two schemes of a program agree as their steps are halved, and its uncertainty."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from study.observer.motion import Quantity
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
        Error of each quantity, relative to its scale.
    fixed
        Whether the times of the output do not depend on the step: the finest two runs have the same times.
    """

    scheme: str
    dt: float
    motion: dict[str, Curve]
    order: dict[str, int]
    error: dict[str, float]
    fixed: bool


class Truth(NamedTuple):
    """The motion on which two schemes agree.

    Attributes
    ----------
    best, witness
        The scheme that gives the motion, and the one with which it is compared.
    uncertainty
        Uncertainty of each quantity, relative to its scale: the difference of the two schemes plus the error of
        interpolation between the steps, or the larger of the two schemes' own errors if it exceeds this sum. The error
        of interpolation is left out if the times of the output are ``fixed``.
    between
        Error of interpolation of each quantity, relative to its scale.
    """

    best: Estimate
    witness: Estimate
    uncertainty: dict[str, float]
    between: dict[str, float]

    @property
    def fixed(self) -> bool:
        """Whether the times of the output do not depend on the step, so that runs are compared at common times."""
        return self.best.fixed and self.witness.fixed

    @property
    def apart(self) -> bool:
        """Whether the two schemes converge to different motions, which the error of interpolation does not explain."""
        largest = max(*self.best.error.values(), *self.witness.error.values())
        return any(
            difference > APART * max(largest, self.between[name]) for name, difference in self.uncertainty.items()
        )

    @property
    def sizes(self) -> dict[str, float]:
        """Largest absolute value of each quantity."""
        return {name: float(curve.sizes.max()) for name, curve in self.best.motion.items()}

    def errors(self, run: Run) -> dict[str, float]:
        """Largest error of each quantity at any time of a run, relative to its scale; NaN if the run failed.

        If the times of the output are ``fixed``, a run at other times has the error of interpolation, too.
        """
        if not run.completed:
            return dict.fromkeys(self.uncertainty, math.nan)
        motion = curves(run)
        errors = {name: motion[name].distance(true, true.scale) for name, true in self.best.motion.items()}
        unseen = self.fixed and not self.shares_times(run)
        return {name: error + self.between[name] for name, error in errors.items()} if unseen else errors

    def shares_times(self, run: Run) -> bool:
        """Whether all times of a run are times of the motion."""
        motion = curves(run)
        return all(true.holds(motion[name].within(true).t) for name, true in self.best.motion.items())


def _extrapolated(coarser: Curve, finer: Curve, order: int) -> Curve:
    """Richardson's extrapolation, at the times of the coarser run."""
    shared = coarser.within(finer)
    values = shared.values - shared.difference(finer) * (1 + 1 / (2**order - 1))
    return Curve(shared.t, values, shared.quantity)


def estimate(runs: Sequence[Run], quantities: Mapping[str, Quantity] | None = None) -> Estimate | None:
    """The motion by a scheme, from its completed runs with halved steps, the finest last; None if there are too few.

    ``quantities`` has the quantities of a problem, which state the scales of errors, by name.
    """
    if len(runs) < FEWEST_RUNS:
        return None
    all_curves = [curves(run, quantities) for run in runs[-RUNS:]]
    motion: dict[str, Curve] = {}
    orders: dict[str, int] = {}
    error: dict[str, float] = {}
    for name in all_curves[-1]:
        along = [run_curves[name] for run_curves in all_curves]
        motion[name], order, error[name] = _limit(along)
        orders |= {name: order} if order else {}
    fixed = np.array_equal(runs[-1].t, runs[-2].t)
    return Estimate(runs[-1].scheme, runs[-1].dt, motion, orders, error, fixed)


def _limit(along: Sequence[Curve]) -> tuple[Curve, int, float]:
    """Limit of a quantity, the order of its extrapolation (zero without extrapolation), and the limit's uncertainty.

    The uncertainty is relative to the scale of the quantity.
    """
    scale = along[-1].scale
    distances = [coarser.distance(finer, scale) for coarser, finer in pairwise(along)]
    observed = [math.log2(a / b) if a > 0 and b > 0 else math.nan for a, b in pairwise(distances)]
    order = round(observed[-1]) if observed[-1] > 0.5 else 0
    near = [abs(value - order) <= off for value, off in zip(reversed(observed), OFF_ORDER, strict=False)]
    # the errors of a single number, such as a peak among steps, have no order
    if order and along[-1].values.ndim and len(near) == len(OFF_ORDER) and all(near):
        previous, last = (_extrapolated(coarser, finer, order) for coarser, finer in list(pairwise(along))[-2:])
        # the whole difference, as for a remainder of first order, which motions with kinks have
        return last, order, previous.distance(last, scale)
    clipped = float(np.clip(observed[-1], *ORDERS)) if distances[-1] > 0 < distances[-2] else ORDERS[0]
    # at least half of the difference before the last one, because the last one may be small by chance
    return along[-1], 0, max(distances[-1], distances[-2] / 2) / (2**clipped - 1)


def agreed(estimates: Iterable[Estimate]) -> Truth | None:
    """The comparison of the two schemes that agree best; None if there are fewer than two schemes."""
    comparisons = [_compared(*pair) for pair in combinations(estimates, 2)]
    return min(comparisons, key=lambda truth: max(truth.uncertainty.values()), default=None)


def _compared(first: Estimate, second: Estimate) -> Truth:
    best, witness = sorted((first, second), key=lambda estimate: max(estimate.error.values()))
    finer, coarser = sorted((first, second), key=lambda estimate: estimate.dt)
    fixed = first.fixed and second.fixed
    uncertainty, between = dict[str, float](), dict[str, float]()
    for name, motion in best.motion.items():
        error = max(first.error[name], second.error[name])
        between[name] = motion.between()
        distance = coarser.motion[name].distance(finer.motion[name], motion.scale)
        uncertainty[name] = max(distance if fixed else distance + between[name], error)
    return Truth(best, witness, uncertainty, between)
