"""Runs of one scheme at many random tolerances, and the largest tolerance below which all runs keep an error."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from study.assessment import errors
from study.assessment.oscillation import QUANTITIES
from study.assessment.search import (
    COARSEST_KEEPS,
    ENERGY,
    FINEST_FAILS,
    FOUND,
    OUT_OF_TIME,
    UNCERTAIN,
    VERDICTS,
    Case,
)
from study.control.controllers import Controller
from study.control.named import estimators
from study.io import flags
from study.marching.control import usual_estimator
from study.marching.run import sweep
from study.scheme.base import Scheme
from study.sizes import Limit, largest_with_margin

#: Largest and smallest tolerance of a search.
LOOSEST, TIGHTEST = 0.1, 1e-12

#: Tolerance down to which runs are made, as a fraction of the tolerance that keeps an error.
HUNDREDTH = 0.01

#: Number of runs made at once, and largest number of steps of a run.
RUNS, MOST_STEPS = 32, 200_000

#: Possible first digits of a recommended tolerance, whose other digits are zero.
DIGITS = (5.0, 2.0, 1.0)


class Tolerance(NamedTuple):
    """Outcome of a search, the tolerance that keeps the error, and error, steps and forces of the run with it.

    ``how`` is the outcome. ``forces`` is the number of internal forces evaluated in all trial steps. ``tried`` is the
    number of tolerances tried from a hundredth of ``tolerance`` up to it. ``largest_error`` is their
    largest error.
    """

    how: int
    tolerance: float = np.nan
    error: float = np.nan
    steps: float = np.nan
    forces: float = np.nan
    tried: int = 0
    largest_error: float = np.nan


#: Outcomes of a search. The last one stands for no search: the scheme needs equal steps, or the quantity is period,
#: phase or amplitude, whose errors need equal steps.
ENDS = (*VERDICTS, "needs_equal_steps")
EQUAL_ONLY = ENDS.index("needs_equal_steps")

#: Name and attributes of each variable of the dataset, in the order of :class:`Tolerance`.
VARIABLES = {
    "tolerance_verdict": flags("how the search for the tolerance ended", ENDS, np.int8),
    "tolerance": {"long_name": "largest round tolerance that keeps the error, as all smaller ones do", "units": "1"},
    "tolerance_error": {"long_name": "error with this tolerance", "units": "1"},
    "controlled_steps": {"long_name": "steps of the run with this tolerance", "units": "1"},
    "controlled_force_evaluations": {"long_name": "internal forces evaluated in the run", "units": "1"},
    "tolerances_tried": {"long_name": "tolerances tried from a hundredth of this tolerance up to it", "units": "1"},
    "tolerance_largest_error": {"long_name": "largest error of the tolerances tried", "units": "1"},
}


def round_tolerance(largest: float) -> float:
    """The largest tolerance up to ``largest`` that is 1, 2 or 5 times a power of ten."""
    unit = 10.0 ** math.floor(math.log10(largest) + 1e-9)
    return next(float(f"{digit * unit:.0e}") for digit in DIGITS if digit * unit <= largest * (1 + 1e-9))


@dataclass
class ToleranceSearch:
    """Runs of one scheme with a controlled step.

    Attributes
    ----------
    scheme, controller
        Scheme and controller of the runs.
    cases
        The problem with several multiples of start and load, by the multiple; 1 is the problem itself.
    duration
        Duration of the runs in s.
    with_energy
        Whether the balance of energies is one of the quantities.
    end
        Value of ``time.monotonic()`` after which no runs begin.
    late
        Whether ``end`` has passed, so that runs may be missing.
    compiling
        Wall time of the first runs in s, most of which is compilation; zero before them.
    runs
        A row for each run: ``start``, ``tolerance``, ``steps``, ``forces``, and the error of each quantity.
    """

    scheme: Scheme
    controller: Controller
    cases: dict[float, Case]
    duration: float
    with_energy: bool
    end: float = math.inf
    late: bool = False
    compiling: float = 0.0
    runs: pd.DataFrame = field(default_factory=pd.DataFrame)

    def __post_init__(self):
        problem = self.cases[1.0].problem
        self._estimator = estimators[usual_estimator(self.scheme, problem)]
        # the step size is proportional to a root of the tolerance
        self._octave = 2.0 ** self._estimator.exponent(self.scheme)
        self._random = np.random.default_rng(0)

    def _run(self, start: float, tolerance: np.ndarray) -> None:
        """Make runs with the given tolerances, with start and load multiplied by ``start``."""
        case = self.cases[start]
        if self.late:
            return
        begin = time.monotonic()
        try:
            ds = sweep(
                case.problem,
                self.scheme,
                tolerance=tolerance,
                duration=self.duration,
                estimator=self._estimator,
                controller=self.controller,
                steps=MOST_STEPS,
                observe=[
                    observer for observer in case.observe if isinstance(observer, str) or not observer.needs_equal_steps
                ],
            )
        except TimeoutError:
            self.late = True
            return
        steps = ds.steps.values
        ends = np.full(len(tolerance), self.duration)
        columns: dict[str, Any] = {name: errors.error(target, ds, ends) for name, target in case.targets.items()}
        columns |= {ENERGY: ds.max_energy_imbalance.values} if self.with_energy else {}
        rows = {"start": start, "tolerance": tolerance, "steps": steps, "forces": ds.force_evaluations.values} | columns
        self.runs = pd.concat([self.runs, pd.DataFrame(rows)], ignore_index=True)
        self.compiling = self.compiling or time.monotonic() - begin
        self.late = time.monotonic() > self.end

    def _drawn(self, bottom: float, top: float, first: Sequence[float] = ()) -> np.ndarray:
        """``RUNS`` tolerances: ``first``, and random ones on the logarithmic scale from ``bottom`` to ``top``."""
        count = RUNS - len(first)
        return np.append(first, top * (bottom / top) ** ((np.arange(count) + self._random.random(count)) / count))

    def largest(self, name: str, allowed: float) -> float:
        """Largest tolerance that keeps an error with a margin for scatter, as all smaller ones do; zero if none."""
        tolerance, error, start = (self.runs[column].to_numpy() for column in ("tolerance", name, "start"))
        return largest_with_margin(tolerance, error, allowed, start == 1.0, self._octave)

    def search(self, limits: Sequence[Limit], report: Callable[[float], None]) -> None:
        """Make runs down to a hundredth of each tolerance that keeps an error, then with the round tolerances.

        The round tolerances are run with every multiple of start and load.
        """
        top, steps = LOOSEST, 0.0
        while not self.late:
            largest = [self.largest(*limit) for limit in limits] if len(self.runs) else [0.0]
            if top > max(HUNDREDTH * min(largest, default=1.0), TIGHTEST) and steps < MOST_STEPS / 2:
                report(top)
                bottom = top / self._octave
                self._run(1.0, self._drawn(bottom, top))
                top, steps = bottom, self.runs.steps.max()
                continue
            new = sorted({round_tolerance(tolerance) for tolerance in largest if tolerance} - {*self.runs.tolerance})
            if not new:
                return
            for start in self.cases:
                self._run(start, self._drawn(new[0] / self._octave, new[-1], new))

    def verdict(self, name: str, allowed: float) -> Tolerance:
        """The verdict of the runs on a quantity and its allowed error."""
        largest = self.largest(name, allowed) if len(self.runs) else 0.0
        unscaled = self.runs[self.runs.start == 1.0] if len(self.runs) else self.runs
        tolerance = round_tolerance(largest) if largest else 0.0
        if self.late and not (tolerance and {*self.runs.start[self.runs.tolerance == tolerance]} == {*self.cases}):
            return Tolerance(OUT_OF_TIME)
        if not tolerance:
            return Tolerance(FINEST_FAILS)
        nearby = unscaled[(unscaled.tolerance >= HUNDREDTH * tolerance) & (unscaled.tolerance <= tolerance)]
        run = unscaled[unscaled.tolerance == tolerance].iloc[0]
        outcome = COARSEST_KEEPS if largest == unscaled.tolerance.max() else FOUND
        return Tolerance(outcome, tolerance, run[name], run.steps, run.forces, len(nearby), nearby[name].max())


def variables_of(
    results: dict[str, dict[Limit, Tolerance] | None], names: list[str], allowed: list[float]
) -> xr.Dataset:
    """The results of all schemes as variables over scheme, quantity and allowed error."""
    rows = []
    for scheme, verdicts in results.items():
        for limit in ((name, error) for name in names for error in allowed):
            default = Tolerance(EQUAL_ONLY if verdicts is None or limit[0] in QUANTITIES else UNCERTAIN)
            rows.append((scheme, *limit, *(verdicts or {}).get(limit, default)))
    index = ["scheme", "quantity", "allowed_error"]
    ds = pd.DataFrame(rows, columns=[*index, *VARIABLES]).set_index(index).to_xarray()
    ds = ds.sel(scheme=list(results), quantity=names, allowed_error=allowed)
    ds = ds.assign(tolerance_verdict=ds.tolerance_verdict.astype(np.int8))
    for name, attributes in VARIABLES.items():
        ds[name].attrs |= attributes
    return ds
