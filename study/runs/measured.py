"""Errors and costs of runs of one scheme on one problem, of any step sizes, durations and starts."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import equinox as eqx
import numpy as np
import pandas as pd

from study.assessment import errors
from study.assessment.arguments import wanted_quantities
from study.assessment.errors import Target
from study.assessment.periods import highest_frequency_along
from study.assessment.reference import NoReference, Reference
from study.assessment.search import ENERGY
from study.assessment.solution import DenseSolution
from study.assessment.steps import spacing
from study.marching.ensemble import FEW, TILE
from study.marching.program import PAUSE_OF_LANES
from study.marching.result import COMPLETED
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.mechanics.loads import excited, restarted, under_stochastic_record
from study.observer.base import Reduction
from study.observer.diagnostics import Evaluations
from study.observer.earlier import AlsoEarlier
from study.observer.energy import EnergyBalance
from study.observer.motion import Quantity
from study.scheme.base import Scheme

#: Relative tolerance of the solvers of a reference, and target error of its interpolant.
RTOL, GOAL = 1e-11, 1e-6
#: Largest variation of initial values and load, for smooth forces and for forces with kinks.
VARIATION, VARIATION_WITH_KINKS = 0.01, 0.05
#: Columns that identify a run of a scheme.
RUN = ["start", "step_size", "duration"]
#: Golden ratio less one; its multiples less whole numbers spread evenly, however many they are.
GOLDEN = (np.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Starts:
    """Problems that differ at most in initial values, and the reference of the quantities of each."""

    problems: list[Problem]
    targets: list[dict[str, Target]]

    @cached_property
    def observed(self) -> list[Reduction]:
        """What is observed in a run."""
        problem = self.problems[0]
        balance = [EnergyBalance()] if problem.potential is not None or problem.dissipative else []
        along = [list(targets.values()) for targets in self.targets]
        return [errors.ErrorsAlong.of(*along), Evaluations(), *balance]


@dataclass(frozen=True)
class Motion:
    """The reference motion of a problem over a duration.

    Attributes
    ----------
    problem
        The problem.
    duration
        The longest duration in s.
    quantities
        Quantities along time whose errors are measured, by name.
    solution
        The reference solution.
    uncertainty
        Difference of two solvers in each quantity, relative to its largest value; zero for the balance of energies.
    solvers
        Names of the two solvers.
    grid
        Times between which the reference is interpolated.
    """

    problem: Problem
    duration: float
    quantities: dict[str, Quantity]
    solution: DenseSolution
    uncertainty: dict[str, float]
    solvers: str
    grid: np.ndarray

    @classmethod
    def of(cls, problem: Problem, duration: float, coarsest: float) -> "Motion":
        """Solve for the reference with two solvers.

        Raises
        ------
        NoReference
            If a solver fails.
        """
        problem = excited(problem, 1.0, displaced=True)
        quantities, reference = wanted_quantities(None, problem), Reference(problem, duration)
        with _reason(problem):
            # with the first route alone, since CVODE takes most of the time
            grid = reference.refined(reference.grid(coarsest), RTOL, GOAL / 2)
            first, second, grid = reference.solutions(grid, RTOL, GOAL)
        apart = {name: errors.difference(q, problem, first, second)[0] for name, q in quantities.items()}
        solvers = " and ".join(route.name for route in reference.routes)
        return cls(problem, duration, quantities, first, apart | {ENERGY: 0.0}, solvers, grid)

    @cached_property
    def names(self) -> list[str]:
        """Names of the quantities."""
        return quantities_of(self.problem)

    @cached_property
    def spacing(self) -> float:
        """Time between the samples of a record in the load, in s; NaN if there is no record."""
        return spacing(self.problem, self.duration) or np.nan

    @cached_property
    def highest_frequency(self) -> float:
        """Highest circular frequency of small motions about points of the motion, in 1/s."""
        return highest_frequency_along(self.problem, self.solution)

    @property
    def several(self) -> bool:
        """Whether there are several unknowns."""
        return np.ndim(self.problem.u0) > 0

    def starts(self, others: int, scale: float) -> list[Starts]:
        """The motion's own start, the first of all, and ``others`` other starts.

        Under a record, they have other, stochastic records, since a multiple of the record would only scale a linear
        motion. Otherwise the start is multiplied (:func:`study.mechanics.loads.restarted`) by equally spaced factors
        within ``VARIATION`` of one, or within ``VARIATION_WITH_KINKS``. A smooth motion that keeps its energy also
        begins in motion, since schemes are more accurate from rest: Fox-Goodwin's method is of fourth order there,
        and of second order from any other start. It begins where its kinetic energy is largest, and at times that the
        golden ratio spreads over ``scale`` seconds. Starts of one unknown
        that differ in initial values alone are in one item of the list, because their runs march side by side.
        """
        if self.problem.ground is not None and np.isfinite(self.spacing):
            problems = [under_stochastic_record(self.problem, seed) for seed in range(1, others + 1)]
        else:
            factors = 1 + (VARIATION_WITH_KINKS if self.problem.has_kinks else VARIATION) * np.linspace(-1, 1, others)
            free = self.problem.conservative and not self.problem.has_kinks
            points = self._in_motion(others, scale) if free else [0] * others
            problems = [restarted(self._from(k), factor) for k, factor in zip(points, factors, strict=True)]
        solved = [(self.problem, self.solution), *((problem, self._solved(problem)) for problem in problems)]
        begins = {(*np.ravel(problem.u0), *np.ravel(problem.v0)) for problem, _ in solved}
        together = not self.several and len(begins) == len(solved)
        return [self._starts(group) for group in ([solved] if together else [[start] for start in solved])]

    def _in_motion(self, others: int, scale: float) -> list[int]:
        """Points of the reference's grid within ``scale`` seconds at which other starts begin."""
        t, v = self.solution.t, self.solution.v[self.solution.t <= scale]
        fastest = np.argmax([np.vdot(velocity, self.problem.momentum(velocity)) for velocity in v])
        spread = scale * (GOLDEN * np.arange(1, others) % 1)
        # the last start has the largest factor, and most schemes err most where the motion is fastest
        return [*(int(np.abs(t - time).argmin()) for time in spread), int(fastest)][:others]

    def _from(self, point: int) -> Problem:
        """The problem that begins with the state of the reference at a point of its grid."""
        state = [history[point] for history in (self.solution.u, self.solution.v)]
        return eqx.tree_at(lambda p: (p.u0, p.v0), self.problem, tuple(state))

    def _starts(self, solved: Sequence[tuple[Problem, DenseSolution]]) -> Starts:
        finer = 1 if self.several else errors.FINER
        targets = [
            {name: errors.target(quantity, problem, solution, finer) for name, quantity in self.quantities.items()}
            for problem, solution in solved
        ]
        return Starts([problem for problem, _ in solved], targets)

    def _solved(self, problem: Problem) -> DenseSolution:
        reference = Reference(problem, self.duration)
        with _reason(problem):
            return reference.solution(reference.routes[0], reference.with_kinks(self.grid), RTOL)


def quantities_of(problem: Problem) -> list[str]:
    """Names of the quantities whose errors are measured."""
    balance = problem.potential is not None or problem.dissipative
    return [*wanted_quantities(None, problem), *([ENERGY] if balance else [])]


@contextmanager
def _reason(problem: Problem) -> Iterator[None]:
    """Say for which problem a solver failed."""
    try:
        yield
    except RuntimeError as error:
        raise NoReference(f"no reference of '{problem.title}' was found: {error}") from error


def measured(scheme: Scheme, starts: Starts, runs: pd.DataFrame, shorter: Sequence[float] = ()) -> pd.DataFrame:
    """Make runs, each of which ends with the last step that fits into its duration.

    Parameters
    ----------
    runs
        A row for each run: ``start``, the number of its problem among the starts, ``step_size`` and ``duration``.
    shorter
        Durations at which longer runs are observed, in place of runs of their own.

    Returns
    -------
    pandas.DataFrame
        ``runs`` with ``status``, the counts, and the error of each quantity, NaN if the run failed. Quantities along
        time are compared with the reference over all unknowns at every step.
    """
    longest = runs[runs.duration == runs.groupby(RUN[:2]).duration.transform("max")]
    results = runs.merge(_marched(scheme, starts, longest[RUN], shorter), "left", on=RUN).set_axis(runs.index)
    missing = runs[results.status.isna()]  # since a longer run failed, perhaps later
    if len(missing):
        results = results.combine_first(measured(scheme, starts, missing, shorter))[results.columns]
    return results


def _marched(scheme: Scheme, starts: Starts, runs: pd.DataFrame, shorter: Sequence[float] = ()) -> pd.DataFrame:
    """Runs with their results, and a row for each shorter duration unless the run failed."""
    steps = np.maximum(np.floor(runs.duration / runs.step_size * (1 + 1e-9)), 1).astype(int)
    remaining = runs.assign(steps=steps).sort_values("steps", kind="stable")  # lanes of about one length end together
    parts, several = list[pd.DataFrame](), np.ndim(starts.problems[0].u0) > 0
    while len(remaining):
        # FEW runs of several unknowns use the program of a single run. Runs of one unknown fill whole tiles and have at
        # most PAUSE_OF_LANES steps in all, since more would need a second program.
        size = FEW if several else max(PAUSE_OF_LANES // remaining.steps.iloc[-1], 1)
        size -= size % TILE if size > TILE else 0
        remaining, part = remaining[:-size], remaining[-size:]
        parts += _with_results(scheme, starts, part, shorter)
    return pd.concat(parts).drop(columns="steps")


def _with_results(
    scheme: Scheme, starts: Starts, runs: pd.DataFrame, shorter: Sequence[float]
) -> Iterator[pd.DataFrame]:
    u0 = v0 = None
    if len(starts.problems) > 1:
        u0, v0 = (np.array([getattr(starts.problems[k], name) for k in runs.start]) for name in ("u0", "v0"))
    arguments = {"dt": runs.step_size.values, "steps": runs.steps.values, "u0": u0, "v0": v0}
    # the round-off of the time of a step is smaller
    observer = AlsoEarlier.of(starts.observed, [duration * (1 + 1e-9) for duration in shorter])
    ds = sweep(starts.problems[0], scheme, observe=observer, **arguments)
    names = {name: target.quantity.name for name, target in starts.targets[0].items()}
    names |= {ENERGY: "max_energy_imbalance"} if "max_energy_imbalance" in ds else {}
    names |= {name: name for name in Evaluations.variables}
    status = {"status": ds.status.values}
    yield runs.assign(**status, **{column: ds[name].values for column, name in names.items()})
    for k, duration in enumerate(shorter):
        values = {column: ds[observer.earlier_name(name, k)].values for column, name in names.items()}
        part = (runs.duration > duration) & (ds.status.values == COMPLETED)
        yield runs.assign(duration=duration, **status, **values)[part]
