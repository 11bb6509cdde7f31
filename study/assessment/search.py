"""Runs of one scheme at many random steps, octave by octave, and the largest step below which all keep an error."""

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from study.analysis.duration import round_down
from study.assessment import errors, oscillation
from study.assessment.errors import Target
from study.assessment.oscillation import Oscillation, OscillationErrors
from study.marching.ensemble import FEW, TILE
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.observer.base import Observer
from study.scheme.base import Scheme
from study.settings import cores
from study.sizes import TWENTIETH, Limit, largest_with_margin

#: Number of steps in a period of the slowest small motion at the coarsest step, with which a search begins.
COARSEST = 4

#: Limits of the finest step of a search. ``FINEST`` is a number of steps in a period of the slowest small motion, and
#: ``FINEST_OF_RUN`` a number of steps × unknowns of a run; the limit that allows more steps holds. ``MOST_STEPS`` is
#: the largest number of steps of a run with the finest step.
FINEST, FINEST_OF_RUN, MOST_STEPS = 2048, 250_000, 4_000_000

#: ``FINEST_OF_HIGHEST`` is the finest Δt·ω of a search, with the highest frequency ω of the motion, since stiff modes
#: need finer steps than the slowest period suggests. ``STEPS_OF_HIGHEST`` and ``WORK_OF_HIGHEST`` are caps on the steps
#: and on the steps × unknowns of a run with this Δt·ω.
FINEST_OF_HIGHEST, STEPS_OF_HIGHEST, WORK_OF_HIGHEST = 0.03, 20_000, 4_000_000

#: Ratio of the finest step tried to the finest step wanted, up to which no finer step is tried. Without this margin,
#: a slight reduction of the largest step that keeps an error would need further runs.
ENOUGH = 1.1

#: Number of runs in an octave of step sizes. ``MOST_RUNS`` is the maximum. ``LEAST_IN_TILES`` is the minimum for short
#: runs of one unknown, which fill a tile of lanes. ``LEAST_RUNS`` is the minimum for long runs or several unknowns.
MOST_RUNS, LEAST_IN_TILES, LEAST_RUNS = 128, TILE, 4

#: Caps on the sum of steps × unknowns over the runs of an octave: True for one unknown, False for several. The minimum
#: number of runs is made in any case.
WORK = {True: 1_500_000, False: 4_000_000}

#: Runs in the octave below a recommended step, where errors are largest. ``CONFIRMED`` is their maximum number. The
#: dicts have a value for one unknown (True) and for several (False): the cap on the sum of steps × unknowns, and the
#: minimum number of runs. The minimum is zero if the recommended step is at most half of the finest step, because
#: otherwise a search might not end.
CONFIRMED, WORK_OF_CONFIRMED, LEAST_CONFIRMED = 500, {True: 3_000_000, False: 4_000_000}, {True: 0, False: 8}

#: Number of steps above which a run of one unknown is made alone. The second number holds if no run of a search has
#: more than ``FINEST_OF_RUN`` steps: compiling the program of a single run then takes as long as it saves.
LONG, LONG_OF_SHORT = 30_000, 120_000

#: Multiples of u₀, u̇₀ and load with which a recommended step must also keep the error.
STARTS = (0.99, 1.01)

#: Outcomes of a search for a step, as indices of ``VERDICTS``.
FOUND, COARSEST_KEEPS, FINEST_FAILS, UNCERTAIN, OUT_OF_TIME = range(5)
#: Names of the outcomes in the dataset.
VERDICTS = ("found", "already_the_coarsest_step", "not_even_the_finest_step", "below_the_reference", "out_of_time")

#: Name of the balance of energies among the quantities.
ENERGY = "energy"


class Recommendation(NamedTuple):
    """Outcome of a search, the largest step that keeps the error, this step rounded down, and the confirming runs.

    ``how`` is the outcome. ``tried`` is the number of steps tried from a twentieth of the recommended step up to it.
    ``largest_error`` is their largest error.
    """

    how: int
    largest: float = np.nan
    recommended: float = np.nan
    tried: int = 0
    largest_error: float = np.nan


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


def spacing(problem: Problem, duration: float) -> float | None:
    """Time in s between the samples of a record in the load; None without a record, or with unevenly spaced samples."""
    times = np.asarray(getattr(problem.load, "kinks", ()))
    gaps = np.diff(times[times < duration])
    return float(gaps.mean()) if len(gaps) and np.ptp(gaps) < 1e-6 * gaps.mean() else None


def finest_step(duration: float, slowest: float, highest: float, unknowns: int) -> float:
    """Finest step of a search, from the slowest period and the highest frequency of small motions."""
    highest_steps = min(highest * duration / FINEST_OF_HIGHEST, STEPS_OF_HIGHEST, WORK_OF_HIGHEST / unknowns)
    steps = max(duration * FINEST / slowest, FINEST_OF_RUN / unknowns, highest_steps)
    return duration / min(MOST_STEPS, steps)


def round_step(largest: float, spacing: float | None) -> float:
    """The largest round step up to ``largest``: with two digits, or an integer multiple or fraction of ``spacing``."""
    if spacing is None:
        return round_down(largest)
    largest *= 1 + 1e-9
    return math.floor(largest / spacing) * spacing if largest >= spacing else spacing / math.ceil(spacing / largest)


class Search:
    """Runs of one scheme on one problem.

    Parameters
    ----------
    scheme
        The scheme.
    cases
        The problem with several multiples of start and load, by the multiple; 1 is the problem itself.
    duration
        Duration in s; a run ends with the last step that fits into it.
    coarsest, finest
        Largest and smallest step in s.
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
        A row for each run: ``start``, ``dt``, ``steps``, ``status``, ``imbalance``, ``iterations``, ``forces``, and the
        error of each quantity.
    """

    def __init__(
        self,
        scheme: Scheme,
        cases: dict[float, Case],
        duration: float,
        coarsest: float,
        finest: float,
        with_energy: bool,
        end: float = math.inf,
    ):
        self.scheme, self.duration, self.coarsest, self.finest = scheme, duration, coarsest, finest
        self._cases, self._with_energy, self._end, self.late, self.compiling = cases, with_energy, end, False, 0.0
        self._long = LONG if duration / finest > 1.01 * FINEST_OF_RUN else LONG_OF_SHORT
        self._size, self._spacing = np.size(cases[1.0].problem.u0), spacing(cases[1.0].problem, duration)
        self.runs, self._random = pd.DataFrame(), np.random.default_rng(0)

    def _run(self, start: float, dt: np.ndarray) -> pd.DataFrame:
        """Rows of one or several runs, with initial values and load multiplied by ``start``."""
        case = self._cases[start]
        steps = np.maximum(np.floor(self.duration / dt * (1 + 1e-9)), 1).astype(int)
        ds = sweep(case.problem, self.scheme, dt=dt, steps=steps, observe=case.observe)
        imbalance = ds.max_energy_imbalance.values if "max_energy_imbalance" in ds else np.nan
        ends = np.atleast_1d(np.minimum(steps * dt, self.duration))
        columns: dict[str, Any] = {name: errors.error(target, ds, ends) for name, target in case.targets.items()}
        columns |= {ENERGY: imbalance} if self._with_energy else {}
        columns |= oscillation.errors(ds) if case.oscillation else {}
        outcome: dict[str, Any] = {
            "status": ds.status.values,
            "imbalance": imbalance,
            "iterations": ds.newton_iterations.values / steps,
            "forces": ds.force_evaluations.values,
        }
        rows: dict[str, Any] = {"start": start, "dt": dt, "steps": steps} | outcome | columns
        return pd.DataFrame({name: np.broadcast_to(values, len(ends)) for name, values in rows.items()})

    def run(self, dt: np.ndarray, start: float = 1.0) -> None:
        """Make runs with the step sizes ``dt``, with start and load multiplied by ``start``.

        The runs with the finest steps are left out if the time does not suffice, so that no gap is left above a step.
        """
        dt = np.sort(dt)[::-1]  # sorted, so that the lanes of a tile end together
        alone = (self.duration / dt > self._long) & (self._size == 1)
        at_once, together = TILE * cores() if self._size == 1 else FEW, dt[~alone]
        parts = [*(together[i : i + at_once] for i in range(0, len(together), at_once)), *dt[alone]]
        for part in parts:
            if self.late and len(self.runs):
                return
            begin = time.perf_counter()
            try:
                self.runs = pd.concat([self.runs, self._run(start, part)], ignore_index=True)
            except TimeoutError:
                self.late = True
                return
            self.compiling = self.compiling or time.perf_counter() - begin
            self.late |= time.monotonic() > self._end

    def _stretch(self, bottom: float, top: float) -> None:
        """Make runs at random steps from ``bottom`` to ``top``.

        The number of runs follows from ``WORK``, within the minimum and the maximum for an octave.
        """
        steps, alone = self.duration / bottom, self._size > 1 or self.duration / bottom > self._long
        least = LEAST_RUNS if alone else LEAST_IN_TILES
        count = int(np.clip(WORK[self._size == 1] / steps / self._size, least, MOST_RUNS)) // least * least
        self.run(self._drawn(bottom, top, count))

    def _drawn(self, bottom: float, top: float, count: int) -> np.ndarray:
        """One random step in each of ``count`` equal parts of the logarithmic scale from ``bottom`` to ``top``."""
        return top * (bottom / top) ** ((np.arange(count) + self._random.random(count)) / count)

    def _unconfirmed(self, steps: Iterable[float]) -> np.ndarray:
        """Random steps that are still missing to confirm each given step; they lie in the octave below it."""
        tried = self._arrays()[0]
        drawn = tried
        for step in sorted(steps, reverse=True):
            work = 2 * self.duration / step * self._size
            single = self._size == 1
            least = LEAST_CONFIRMED[single] if step > self.finest / 2 else 0
            required = int(np.clip(WORK_OF_CONFIRMED[single] / work, least, CONFIRMED))
            missing = required - int(((drawn >= step / 2) & (drawn <= step)).sum())
            drawn = np.append(drawn, self._drawn(step / 2, step, max(missing, 0)))
        return drawn[len(tried) :]

    def _arrays(self, name: str = "dt") -> tuple[np.ndarray, np.ndarray]:
        """Steps of the runs whose start and load are not scaled, and the values of one column of these runs."""
        unscaled = self.runs.start.to_numpy() == 1.0
        return self.runs.dt.to_numpy()[unscaled], self.runs[name].to_numpy()[unscaled]

    def largest(self, name: str, allowed: float) -> float:
        """Largest step that keeps an error with a margin for scatter, as all finer steps do; zero if there is none."""
        dt, error, start = (self.runs[column].to_numpy() for column in ("dt", name, "start"))
        return largest_with_margin(dt, error, allowed, start == 1.0)

    def search(self, limits: Sequence[Limit], report: Callable[[float], None] = lambda top: None) -> None:
        """Make runs down to a twentieth of the smallest step that a limit needs, then runs that confirm the steps.

        A limit is a quantity with an allowed error. It needs the largest step that keeps this error, which is rounded
        down. The rounded step is run with every multiple of start and load. Random steps in the octave below it are run
        too.
        """
        top = self.coarsest
        while not self.late:
            largest = [self.largest(*limit) for limit in limits] if len(self.runs) else [0.0]
            least = TWENTIETH * min(largest, default=np.inf)
            if top > ENOUGH * max(least, self.finest):
                report(top)
                bottom = max(top / 2, least, self.finest)
                self._stretch(bottom, top)
                top = bottom
                continue
            steps = {round_step(step, self._spacing) for step in largest if step}
            new, missing = np.array(sorted(steps - {*self._arrays()[0]})), self._unconfirmed(steps)
            if not len(new) + len(missing):
                return
            report(max(steps))
            self.run(np.append(new, missing))
            for start in self._cases:
                if start != 1.0 and len(new):
                    self.run(new, start)

    def _round(self, limit: Limit) -> float:
        largest = self.largest(*limit)
        return round_step(largest, self._spacing) if largest else 0.0

    def _known(self, step: float) -> bool:
        """Whether a step, from all starts, and all runs that confirm it have been made."""
        starts, tried = self.runs.start[self.runs.dt == step], self._arrays()[0]
        finer = tried.min() <= TWENTIETH * step and not len(self._unconfirmed([step]))
        return finer and {*starts} == {*self._cases}

    def verdict(self, name: str, allowed: float) -> Recommendation:
        """The verdict of the runs on a quantity and its allowed error."""
        step = self._round((name, allowed))
        if self.late and not (step and self._known(step)):
            return Recommendation(OUT_OF_TIME, self.largest(name, allowed) or np.nan)
        if not step:
            return Recommendation(FINEST_FAILS)
        unscaled = self.runs[self.runs.start == 1.0]
        nearby = unscaled[(unscaled.dt >= TWENTIETH * step) & (unscaled.dt <= step)]
        largest = self.largest(name, allowed)
        outcome = COARSEST_KEEPS if largest == unscaled.dt.max() else FOUND
        return Recommendation(outcome, largest, step, len(nearby), nearby[name].max())
