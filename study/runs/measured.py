"""Errors and costs of one scheme on one problem, at any step sizes, over several durations and from several starts."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from study.assessment import errors
from study.assessment.arguments import wanted_quantities
from study.assessment.errors import Target
from study.assessment.reference import NoReference, Reference
from study.assessment.search import ENERGY, spacing
from study.assessment.solution import DenseSolution
from study.marching.ensemble import FEW
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.mechanics.loads import excited, later, restarted
from study.observer.base import Observer
from study.observer.motion import Quantity
from study.scheme.base import Scheme

#: Relative tolerance of the solvers of a reference, and target error of its interpolant.
RTOL, GOAL = 1e-11, 1e-6
#: Largest variation of initial values and load, for smooth forces and for forces with kinks.
VARIATION, VARIATION_WITH_KINKS = 0.01, 0.05


@dataclass(frozen=True)
class Start:
    """A problem with a changed start or load, and the reference of its quantities."""

    problem: Problem
    targets: dict[str, Target]
    sampled: bool

    @cached_property
    def observe(self) -> list[str | Observer]:
        """The observers of a run."""
        balance = ["energy_balance"] if self.problem.potential is not None or self.problem.dissipative else []
        along = list(self.targets.values())
        return [*([errors.ErrorsAtSamples.of(along)] if self.sampled else errors.observers(along)), "effort", *balance]


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
        Times between which the reference is interpolated, or times of its samples.
    sampled
        Whether errors are measured at the samples only. The dense reference of several unknowns takes long.
    """

    problem: Problem
    duration: float
    quantities: dict[str, Quantity]
    solution: DenseSolution
    uncertainty: dict[str, float]
    solvers: str
    grid: np.ndarray
    sampled: bool

    @classmethod
    def of(cls, problem: Problem, duration: float, coarsest: float, sampled: float | None = None) -> "Motion":
        """Solve for the reference with two solvers, at samples in intervals of ``sampled`` seconds if it is given.

        Raises
        ------
        NoReference
            If a solver fails.
        """
        problem = excited(problem, 1.0, displaced=True)
        quantities, reference = wanted_quantities(None, problem), Reference(problem, duration)
        try:
            if sampled is None:
                one, other, grid = reference.solutions(reference.grid(coarsest), RTOL, GOAL)
            else:
                grid = np.linspace(0.0, duration, round(duration / sampled) + 1)
                one, other = (reference.solution(route, grid, RTOL) for route in reference.routes)
        except RuntimeError as error:
            raise NoReference(f"no reference of '{problem.title}' was found: {error}") from error
        apart = {name: errors.difference(q, problem, one, other)[0] for name, q in quantities.items()}
        solvers = " and ".join(route.name for route in reference.routes)
        return cls(problem, duration, quantities, one, apart | {ENERGY: 0.0}, solvers, grid, sampled is not None)

    @property
    def names(self) -> list[str]:
        """Names of the quantities."""
        balance = self.problem.potential is not None or self.problem.dissipative
        return [*self.quantities, *([ENERGY] if balance else [])]

    @cached_property
    def own(self) -> Start:
        """The problem from its own start."""
        return self._start(self.problem, self.solution)

    def _start(self, problem: Problem, solution: DenseSolution) -> Start:
        finer = 1 if self.sampled else errors.FINER
        targets = {name: errors.target(one, problem, solution, finer) for name, one in self.quantities.items()}
        return Start(problem, targets, self.sampled)

    @cached_property
    def spacing(self) -> float:
        """Time between the samples of a record in the load, in s; NaN if there is no record."""
        return spacing(self.problem, self.duration) or np.nan

    @property
    def kinked(self) -> bool:
        """Whether the force has kinks. The error then varies irregularly with the step and the start."""
        return self.problem.kinked or self.problem.history is not None

    def others(self, number: int) -> list[Start]:
        """Other starts of the motion.

        Under a record, they begin 1, 2, ... ``number`` samples later, since a multiple of the record would only scale a
        linear motion. Otherwise the start is multiplied (:func:`study.mechanics.loads.restarted`) by ``number`` equally
        spaced factors within ``VARIATION`` of one, or within ``VARIATION_WITH_KINKS``.
        """
        if self.problem.ground is not None and np.isfinite(self.spacing):
            return [self._solved(later(self.problem, samples)) for samples in range(1, number + 1)]
        factors = 1 + (VARIATION_WITH_KINKS if self.kinked else VARIATION) * np.linspace(-1, 1, number)
        return [self._solved(restarted(self.problem, factor)) for factor in factors]

    def _solved(self, problem: Problem) -> Start:
        reference = Reference(problem, self.duration)
        grid = self.grid if self.sampled else reference.with_kinks(self.grid)
        return self._start(problem, reference.solution(reference.routes[0], grid, RTOL))


def measured(scheme: Scheme, start: Start, step_sizes: Sequence[float], durations: Sequence[float]) -> pd.DataFrame:
    """Runs at each step size over each duration.

    A run ends with the last step that fits into the duration.

    Returns
    -------
    pandas.DataFrame
        A row for each run: ``step_size``, ``duration``, ``status``, the counts, and the error of each quantity, NaN if
        the run failed. Quantities along time are compared with the reference over all unknowns, at every step or at
        the samples of the reference.
    """
    dt, ends = (one.ravel() for one in np.meshgrid(step_sizes, durations, indexing="ij"))
    steps = np.maximum(np.floor(ends / dt * (1 + 1e-9)), 1).astype(int)
    order = np.argsort(steps, kind="stable")  # lanes of about one length end together
    parts = [order[i : i + FEW] for i in range(0, len(order), FEW)]
    return pd.concat([_rows(scheme, start, dt[part], steps[part], ends[part]) for part in parts], ignore_index=True)


def _rows(scheme: Scheme, start: Start, dt: np.ndarray, steps: np.ndarray, ends: np.ndarray) -> pd.DataFrame:
    ds = sweep(start.problem, scheme, dt=dt, steps=steps, observe=start.observe)
    reached = np.minimum(steps * dt, ends)
    found = {name: errors.error(target, ds, reached) for name, target in start.targets.items()}
    if "max_energy_imbalance" in ds:
        found[ENERGY] = ds.max_energy_imbalance.values
    counts = {name: ds[name].values for name in ("force_evaluations", "tangent_evaluations", "factorisations")}
    return pd.DataFrame({"step_size": dt, "duration": ends, "status": ds.status.values} | counts | found)
