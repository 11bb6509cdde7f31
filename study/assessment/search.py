"""Runs of one scheme at many sizes, steps or tolerances, and the largest size below which all keep an error."""

import math
import time
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from study.assessment import errors, oscillation
from study.assessment.errors import Target
from study.assessment.oscillation import Oscillation, OscillationErrors
from study.mechanics.definition import Problem
from study.observer.base import Observer
from study.scheme.base import Scheme
from study.sizes import Needed, needed

#: Multiples of u₀, u̇₀ and load with which a recommended step must also keep the error.
STARTS = (0.99, 1.01)

#: Outcomes of a search for a step, as indices of ``VERDICTS``.
FOUND, COARSEST_KEEPS, FINEST_FAILS, UNCERTAIN, OUT_OF_TIME = range(5)
#: Names of the outcomes in the dataset.
VERDICTS = ("found", "already_the_coarsest_step", "not_even_the_finest_step", "below_the_reference", "out_of_time")

#: Name of the balance of energies among the quantities.
ENERGY = "energy"


class Verdict(NamedTuple):
    """Outcome of a search, the sizes that keep the error, the runs that confirm them, and the run with this size.

    ``how`` is the outcome, ``largest`` the largest size that keeps the error, and ``recommended`` this size rounded
    down. ``tried`` is the number of sizes tried that confirm it, and ``largest_error`` their largest error. ``error``,
    ``steps`` and ``forces`` are those of the run with the recommended size.
    """

    how: int
    largest: float = np.nan
    recommended: float = np.nan
    tried: int = 0
    largest_error: float = np.nan
    error: float = np.nan
    steps: float = np.nan
    forces: float = np.nan


@dataclass(frozen=True)
class Case:
    """The problem with a multiple of its u₀, u̇₀ and load, and its reference."""

    problem: Problem
    targets: dict[str, Target]
    oscillation: Oscillation | None

    @cached_property
    def observe(self) -> list[str | Observer]:
        """The observers of a run."""
        energy_observers = ["energy_balance"] if self.problem.potential is not None else []
        oscillation_observers = [OscillationErrors(self.oscillation)] if self.oscillation else []
        return [
            *errors.observers(list(self.targets.values())),
            "newton_iterations",
            "effort",
            *energy_observers,
            *oscillation_observers,
        ]


def sentence_on_starts(cases: dict[float, Case]) -> str:
    """A sentence on the runs with start and load one percent away, or on their absence if start and load are zero."""
    problem = cases[1.0].problem
    neighbours = [case.problem for factor, case in cases.items() if factor != 1.0]
    if problem.load is None and all(
        np.array_equal(neighbour.u0, problem.u0) and np.array_equal(neighbour.v0, problem.v0)
        for neighbour in neighbours
    ):
        return "No other start was tried: initial displacement, initial velocity and load are zero."
    return "Runs from two starts, one percent below and above, keep the error too."


class Search:
    """Runs of one scheme on one problem, at sizes that a subclass chooses.

    Parameters
    ----------
    scheme
        The scheme.
    cases
        The problem with several multiples of start and load, by the multiple; 1 is the problem itself.
    duration
        Duration in s.
    with_energy
        Whether the balance of energies is one of the quantities.
    end
        Value of ``time.monotonic()`` after which no runs begin, except the first ones.

    Attributes
    ----------
    late
        Whether ``end`` has passed, so that runs may be missing.
    compiling
        Wall time of the first runs in s, most of which is compilation; zero before them.
    runs
        A row for each run: ``start``, its size, ``steps``, ``status``, ``imbalance``, ``iterations``, ``forces``, and
        the error of each quantity.
    """

    #: Name of the size in ``runs``.
    size: ClassVar[str]
    #: Smallest size that confirms a recommended one, as a fraction of it.
    confirming: ClassVar[float]
    #: Ratio of two sizes if the steps of one are twice as long as those of the other.
    octave: float = 2.0

    def __init__(
        self, scheme: Scheme, cases: dict[float, Case], duration: float, with_energy: bool, end: float = math.inf
    ):
        self.scheme, self.duration = scheme, duration
        self._cases, self._with_energy, self._end = cases, with_energy, end
        self.runs, self.late, self.compiling = pd.DataFrame(), False, 0.0
        self._random = np.random.default_rng(0)

    def _sweep(self, case: Case, sizes: np.ndarray) -> tuple[xr.Dataset, np.ndarray, np.ndarray]:
        """Runs of the scheme, with the number of steps and the end of each."""
        raise NotImplementedError

    def _round(self, largest: float) -> float:
        """The largest round size up to a size."""
        raise NotImplementedError

    def _run(self, start: float, sizes: np.ndarray) -> pd.DataFrame:
        """Rows of runs, with initial values and load multiplied by ``start``."""
        case = self._cases[start]
        ds, steps, ends = self._sweep(case, sizes)
        imbalance = ds.max_energy_imbalance.values if "max_energy_imbalance" in ds else np.nan
        columns: dict[str, Any] = {name: errors.error(target, ds, ends) for name, target in case.targets.items()}
        columns |= {ENERGY: imbalance} if self._with_energy else {}
        columns |= oscillation.errors(ds)
        outcome: dict[str, Any] = {
            "status": ds.status.values,
            "imbalance": imbalance,
            "iterations": ds.newton_iterations.values / steps,
            "forces": ds.force_evaluations.values,
        }
        rows: dict[str, Any] = {"start": start, self.size: sizes, "steps": steps} | outcome | columns
        return pd.DataFrame({name: np.broadcast_to(values, len(ends)) for name, values in rows.items()})

    def _add(self, start: float, sizes: np.ndarray) -> None:
        """Make runs, unless the time is over."""
        begin = time.perf_counter()
        try:
            self.runs = pd.concat([self.runs, self._run(start, sizes)], ignore_index=True)
        except TimeoutError:
            self.late = True
            return
        self.compiling = self.compiling or time.perf_counter() - begin
        self.late |= time.monotonic() > self._end

    def _drawn(self, bottom: float, top: float, count: int) -> np.ndarray:
        """One random size in each of ``count`` equal parts of the logarithmic scale from ``bottom`` to ``top``."""
        return top * (bottom / top) ** ((np.arange(count) + self._random.random(count)) / count)

    def _own(self) -> pd.DataFrame:
        """The runs whose start and load are not scaled."""
        return self.runs[self.runs.start == 1.0]

    def needed(self, name: str, allowed: float) -> Needed:
        """What the runs so far need for a quantity and its allowed error."""
        if not len(self.runs):
            return Needed(0.0, 0.0, 0, math.nan)
        size, error, start = (self.runs[column].to_numpy() for column in (self.size, name, "start"))
        return needed(size, error, allowed, self._round, start == 1.0, self.octave, self.confirming)

    def _known(self, size: float) -> bool:
        """Whether the runs with a size from all starts have been made."""
        return {*self.runs.start[self.runs[self.size] == size]} == {*self._cases}

    def verdict(self, name: str, allowed: float) -> Verdict:
        """The verdict of the runs on a quantity and its allowed error."""
        found = self.needed(name, allowed)
        size = found.recommended
        if self.late and not (size and self._known(size)):
            return Verdict(OUT_OF_TIME, found.largest or np.nan)
        if not size:
            return Verdict(FINEST_FAILS)
        own = self._own()
        run = own[own[self.size] == size].iloc[0]
        outcome = COARSEST_KEEPS if found.largest == own[self.size].max() else FOUND
        return Verdict(outcome, *found, run[name], run.steps, run.forces)
