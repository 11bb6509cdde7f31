"""The largest tolerance of a controlled step that keeps an error: runs of one scheme at many random tolerances."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
import xarray as xr

from study.assessment.oscillation import QUANTITIES
from study.assessment.search import UNCERTAIN, VERDICTS, Case, Search, Verdict
from study.control.controllers import Controller
from study.control.named import estimators
from study.io import flags
from study.marching.control import usual_estimator
from study.marching.run import sweep
from study.scheme.base import Scheme
from study.sizes import Limit

#: Largest and smallest tolerance of a search.
LOOSEST, TIGHTEST = 0.1, 1e-12

#: Tolerance down to which runs are made, as a fraction of the tolerance that keeps an error.
HUNDREDTH = 0.01

#: Number of runs made at once, and largest number of steps of a run.
RUNS, MOST_STEPS = 32, 200_000

#: Possible first digits of a recommended tolerance, whose other digits are zero.
DIGITS = (5.0, 2.0, 1.0)


#: Outcomes of a search. The last one stands for no search: the scheme needs equal steps, or the quantity is period,
#: phase or amplitude, whose errors need equal steps.
ENDS = (*VERDICTS, "needs_equal_steps")
EQUAL_ONLY = ENDS.index("needs_equal_steps")

#: Name and attributes of each variable of the dataset.
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


class ToleranceSearch(Search):
    """Runs with a controlled step.

    Parameters
    ----------
    scheme, cases, duration, with_energy, end
        As for :class:`study.assessment.search.Search`.
    controller
        The controller of the step.
    """

    size, confirming = "tolerance", HUNDREDTH

    def __init__(
        self,
        scheme: Scheme,
        controller: Controller,
        cases: dict[float, Case],
        duration: float,
        with_energy: bool,
        end: float = math.inf,
    ):
        super().__init__(scheme, cases, duration, with_energy, end)
        self.controller, self._estimator = controller, estimators[usual_estimator(scheme, cases[1.0].problem)]
        # the step size is proportional to a root of the tolerance
        self.octave = 2.0 ** self._estimator.exponent(scheme)

    def _sweep(self, case: Case, sizes: np.ndarray) -> tuple[xr.Dataset, np.ndarray, np.ndarray]:
        ds = sweep(
            case.problem,
            self.scheme,
            tolerance=sizes,
            duration=self.duration,
            estimator=self._estimator,
            controller=self.controller,
            steps=MOST_STEPS,
            observe=[
                observer for observer in case.observe if isinstance(observer, str) or not observer.needs_equal_steps
            ],
        )
        return ds, ds.steps.values, np.full(len(sizes), self.duration)

    def _round(self, largest: float) -> float:
        return round_tolerance(largest)

    def _run_to(self, bottom: float, top: float, start: float = 1.0, first: Sequence[float] = ()) -> None:
        """Make ``RUNS`` runs with the tolerances ``first`` and random ones from ``bottom`` to ``top``."""
        if not self.late:
            self._add(start, np.append(first, self._drawn(bottom, top, RUNS - len(first))))

    def search(self, limits: Sequence[Limit], report: Callable[[float], None]) -> None:
        """Make runs down to a hundredth of each tolerance that keeps an error, then with the round tolerances.

        The round tolerances are run with every multiple of start and load.
        """
        top, steps = LOOSEST, 0.0
        while not self.late:
            largest = [self.needed(*limit).largest for limit in limits] if len(self.runs) else [0.0]
            if top > max(HUNDREDTH * min(largest, default=1.0), TIGHTEST) and steps < MOST_STEPS / 2:
                report(top)
                bottom = top / self.octave
                self._run_to(bottom, top)
                top, steps = bottom, self.runs.steps.max()
                continue
            new = sorted({self._round(tolerance) for tolerance in largest if tolerance} - {*self.runs.tolerance})
            if not new:
                return
            for start in self._cases:
                self._run_to(new[0] / self.octave, new[-1], start, new)


def variables_of(results: dict[str, dict[Limit, Verdict] | None], names: list[str], allowed: list[float]) -> xr.Dataset:
    """The results of all schemes as variables over scheme, quantity and allowed error."""
    rows = []
    for scheme, verdicts in results.items():
        for limit in ((name, error) for name in names for error in allowed):
            default = Verdict(EQUAL_ONLY if verdicts is None or limit[0] in QUANTITIES else UNCERTAIN)
            found = (verdicts or {}).get(limit, default)
            run = (found.recommended, found.error, found.steps, found.forces)
            rows.append((scheme, *limit, found.how, *run, found.tried, found.largest_error))
    index = ["scheme", "quantity", "allowed_error"]
    ds = pd.DataFrame(rows, columns=[*index, *VARIABLES]).set_index(index).to_xarray()
    ds = ds.sel(scheme=list(results), quantity=names, allowed_error=allowed)
    ds = ds.assign(tolerance_verdict=ds.tolerance_verdict.astype(np.int8))
    for name, attributes in VARIABLES.items():
        ds[name].attrs |= attributes
    return ds
