"""Runs of one scheme at ever finer steps, and the largest step that keeps an error, found and confirmed by runs."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from study.assessment import errors, oscillation
from study.assessment.errors import Target
from study.assessment.oscillation import Oscillation
from study.assessment.solution import DenseSolution
from study.marching.run import run
from study.mechanics.definition import Problem
from study.observer.base import Observer
from study.problem.named import neighbouring_starts
from study.scheme.base import Scheme

#: Steps in which a ladder begins in a period of the slowest small motion.
COARSEST = 4

#: Steps up to which a ladder climbs: in a period of the slowest small motion, or, if that is more, in a run of one
#: unknown; of several, that over their number.
FINEST, MOST_STEPS = 2048, 4_000_000

#: Rungs beyond the first that keeps every error, to see whether finer steps keep it too.
BEYOND = 2

#: Most samples of a run along time, for which a compiled march has room at once.
SAMPLES = 4000

#: Ratio of a number of steps that keeps an error to the next smaller one, which does not, at which a search ends.
CLOSE = 2 ** (1 / 16)

#: Finer steps, as multiples of the number of steps, and starts, as multiples of u₀, u̇₀ and load, that must keep the
#: error too. The steps reach almost to the next rung, since errors follow no law where a load is faster than the step.
AROUND, STARTS = (1.03, 1.06, 1.1, 1.2, 1.35, 1.6), tuple(neighbouring_starts.values())

#: Steps that are tried after one that kept the error by accident, and searches until none makes a run that another
#: would have to heed.
ATTEMPTS, SEARCHES = 12, 10

#: Least ratio of an error to the uncertainty of the reference.
CERTAIN = 10

#: How a search for a step ended.
FOUND, COARSEST_KEEPS, FINEST_FAILS, BY_ACCIDENT, UNCERTAIN = range(5)
VERDICTS = (
    "found",
    "already_the_coarsest_step",
    "not_even_the_finest_step",
    "by_accident_only",
    "below_the_reference",
)

#: Name of the balance of energies among the quantities.
ENERGY = "energy"


class Try(NamedTuple):
    """One run: its errors by quantity, how it ended, its imbalance of energy, and its Newton iterations a step."""

    errors: dict[str, float]
    status: int
    failed_at_step: int
    imbalance: float
    iterations: float


#: A quantity, and the error that it is allowed.
Limit = tuple[str, float]


class Recommendation(NamedTuple):
    """The fewest steps that keep an error, how the search ended, and how many fewer kept it by accident."""

    steps: int
    how: int
    accidents: int


class Case(NamedTuple):
    """A start of the problem, as a multiple of u₀, u̇₀ and load, with its reference and what that says."""

    problem: Problem
    solution: DenseSolution
    targets: dict[str, Target]
    oscillation: Oscillation | None


def told_of_starts(cases: dict[float, Case]) -> str:
    """A sentence on the starts beside that of the problem: a multiple of nothing is no other start."""
    own = cases[1.0].problem
    others = [case.problem for factor, case in cases.items() if factor != 1.0]
    if own.load is None and all(np.array_equal(one.u0, own.u0) and np.array_equal(one.v0, own.v0) for one in others):
        return "No other start was tried: u, u̇ and the load are zero at the start."
    return "Two starts, one percent below and above, keep it too."


class Ladder:
    """Runs of one scheme on one problem, each made once.

    Parameters
    ----------
    scheme
        The scheme.
    cases
        The problem and its neighbours by the multiple of their start; that of 1 is the problem itself.
    duration
        Length of the runs.
    of_energy
        Whether the balance of energies is one of the quantities.
    finest
        Most steps of a rung.
    """

    def __init__(self, scheme: Scheme, cases: dict[float, Case], duration: float, of_energy: bool, finest: int):
        self.scheme, self.duration, self.finest = scheme, duration, finest
        self._cases, self._of_energy = cases, of_energy
        self.tries: dict[tuple[int, float], Try] = {}
        self.rungs: list[int] = []
        problem = cases[1.0].problem
        energy: Sequence[str] = ("energy_balance",) if problem.potential is not None else ()
        quantities = [target.quantity for target in cases[1.0].targets.values()]
        self._observe: list[str | Observer] = [*quantities, *energy, "newton_iterations"]
        self._records = any(quantity.reduce is None for quantity in quantities)

    def rounded(self, steps: float) -> int:
        """The number of steps next to another one that a run can take, because its samples divide it."""
        every = self._every(steps)
        return max(1, round(steps / every)) * every

    def _every(self, steps: float) -> int:
        return 1 if not self._records else 2 ** max(0, int(np.ceil(np.log2(steps / SAMPLES))))

    def run(self, steps: int, start: float = 1.0) -> Try:
        """The run of that many steps from a multiple of the start."""
        if (steps, start) not in self.tries:
            case, dt = self._cases[start], self.duration / steps
            ds = run(
                case.problem,
                self.scheme,
                dt=dt,
                steps=steps,
                every=self._every(steps),
                observe=[*self._observe, *(case.oscillation.observers(dt) if case.oscillation else ())],
                on_failure="ignore",
            )
            found = {
                name: errors.error(target, case.problem, case.solution, ds) for name, target in case.targets.items()
            }
            imbalance = float(ds.max_energy_imbalance) / 100 if "max_energy_imbalance" in ds else np.nan
            if self._of_energy:
                found[ENERGY] = imbalance
            if case.oscillation:
                found |= oscillation.errors(ds)
            self.tries[steps, start] = Try(
                found, int(ds.status), int(ds.failed_at_step), imbalance, float(ds.newton_iterations) / steps
            )
        return self.tries[steps, start]

    def climb(self, coarsest: int, tightest: float) -> None:
        """Run at ever finer steps until every quantity keeps the tightest error, and a few rungs more."""
        kept, steps = 0, coarsest
        while (steps <= self.finest or not self.rungs) and kept <= BEYOND:
            self.rungs.append(self.rounded(steps))
            found = self.run(self.rungs[-1]).errors.values()
            kept = kept + 1 if all(error <= tightest for error in found) else 0
            steps *= 2

    def steps_of(self, start: float = 1.0) -> list[int]:
        """Numbers of steps of all runs so far, from coarse to fine."""
        return sorted(steps for steps, of in self.tries if of == start)

    def _keeps(self, steps: int, name: str, allowed: float) -> bool:
        """Whether the runs of that many steps so far keep the error, from all starts that were tried."""
        tried = (self.tries[steps, start] for start in (1.0, *STARTS) if (steps, start) in self.tries)
        return all(one.errors[name] <= allowed for one in tried)

    def _keeps_from_all_starts(self, steps: int, name: str, allowed: float) -> bool:
        starts = (1.0, *(start for start in STARTS if start in self._cases))
        return all(self.run(steps, start).errors[name] <= allowed for start in starts)

    def _fewest(self, name: str, allowed: float) -> int | None:
        """Fewest steps of all runs so far from which on every finer run keeps the error; None if the finest fails."""
        fewest = None
        for steps in reversed(self.steps_of()):
            if not self._keeps(steps, name, allowed):
                break
            fewest = steps
        return fewest

    def _finer_ones(self, steps: int) -> list[int]:
        """Numbers of steps that are larger, up to almost twice."""
        finer = [steps]
        for more in AROUND:
            finer.append(max(self.rounded(steps * more), finer[-1] + self._every(steps)))
        return [one for one in finer[1:] if one <= MOST_STEPS]

    def _verdict(self, name: str, allowed: float, uncertainty: float) -> Recommendation:
        if allowed < CERTAIN * uncertainty:
            return Recommendation(-1, UNCERTAIN, 0)
        for _ in range(ATTEMPTS):
            fewest = self._fewest(name, allowed)
            if fewest is None and 2 * self.steps_of()[-1] <= self.finest:  # another start needs finer steps
                self.rungs.append(self.rounded(2 * self.steps_of()[-1]))
                self.run(self.rungs[-1])
                continue
            if fewest is None:
                return Recommendation(-1, FINEST_FAILS, 0)
            if not self._keeps_from_all_starts(fewest, name, allowed):
                continue
            coarser = max((steps for steps in self.steps_of() if steps < fewest), default=0)
            while coarser and fewest > CLOSE * coarser:
                between = self.rounded(np.sqrt(coarser * fewest))
                if not coarser < between < fewest:
                    break
                kept = self._keeps_from_all_starts(between, name, allowed)
                coarser, fewest = (coarser, between) if kept else (between, fewest)
            if all(self.run(one).errors[name] <= allowed for one in self._finer_ones(fewest)):
                coarser_ones = [steps for steps in self.steps_of() if steps < fewest]
                accidents = sum(self.run(steps).errors[name] <= allowed for steps in coarser_ones)
                return Recommendation(fewest, FOUND if coarser else COARSEST_KEEPS, accidents)
        return Recommendation(-1, BY_ACCIDENT, ATTEMPTS)

    def verdicts(
        self, limits: Sequence[tuple[str, float]], uncertainty: dict[str, float]
    ) -> dict[Limit, Recommendation]:
        """The fewest steps that keep each error of a quantity, on which no run made for another one casts doubt.

        Parameters
        ----------
        limits
            Quantities with the errors that are allowed.
        uncertainty
            That of the reference by quantity; an error of less than ten times it cannot be told.
        """
        for _ in range(SEARCHES):
            before = len(self.tries)
            found = {limit: self._verdict(*limit, uncertainty[limit[0]]) for limit in limits}
            if len(self.tries) == before:
                return found
        doubted = Recommendation(-1, BY_ACCIDENT, ATTEMPTS)
        return {
            limit: doubted if verdict.steps > 0 and self._fewest(*limit) != verdict.steps else verdict
            for limit, verdict in found.items()
        }
