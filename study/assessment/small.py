"""``study.assess`` for few unknowns, all with a mass: random steps, octave by octave, against a certified reference."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

import numpy as np
import pandas as pd
import xarray as xr

from study.algebra.deadline import until
from study.algebra.reads import reading
from study.analysis.orders import observed_order
from study.assessment import failures, oscillation, steps
from study.assessment.arguments import OFF_ORDER, Question
from study.assessment.certified import KINKS, cases_of, certified, undeclared
from study.assessment.dataset import Assessed, dataset_of
from study.assessment.deadline import Budget, OutOfTime, within
from study.assessment.errors import DEFAULT
from study.assessment.periods import has_a_period, highest_frequency_along, slowest_period
from study.assessment.progress import Progress
from study.assessment.scales import lack_of_energy, measured, remarks_on_scales, with_reference
from study.assessment.search import ENERGY, Verdict, sentence_on_starts
from study.assessment.steps import StepSearch
from study.assessment.tolerances import ToleranceSearch, variables_of
from study.io import processor
from study.mechanics.loads import record_of
from study.scheme.base import Scheme
from study.settings import cores
from study.sizes import CERTAIN, Limit
from study.warn import warn

#: Observed order of your own schemes: largest error that counts, least ratio of an error to the uncertainty of the
#: reference, ratio of the largest to the smallest step, and least number of runs.
LARGE, SURE, FINE, LEAST_RUNS = 0.05, 100, 8, 8


class _Assessment:
    """The reference of a problem, and the runs of schemes against it, within a wall time.

    Raises
    ------
    ValueError
        If the duration has too many steps, or as :func:`study.assessment.certified.certified`.
    OutOfTime
        If the time ends before there is a reference.
    """

    def __init__(self, question: Question, progress: Progress):
        self.question, self.progress = question, progress
        self.budget = Budget(time.monotonic() + question.seconds)
        slowest = slowest_period(question.problem) or question.duration / steps.COARSEST
        self.coarsest = slowest / steps.COARSEST
        self._check_duration()
        self._solve()
        unknowns = np.size(question.problem.u0)
        self.highest_frequency = highest_frequency_along(question.problem, self.reference.solution)
        self.duration = self.reference.horizon
        self.finest = steps.finest_step(self.duration, slowest, self.highest_frequency, unknowns)
        balance = [ENERGY] if self.with_energy else []
        self.names = [*question.quantities, *balance, *(oscillation.QUANTITIES if self.reference.oscillation else [])]
        self.uncertainty = self.reference.uncertainty | dict.fromkeys(balance, 0.0)
        self.limits: list[Limit] = [
            (name, error)
            for name in self.names
            for error in question.allowed
            if error >= CERTAIN * self.uncertainty[name]
        ]

    def _check_duration(self) -> None:
        title, longest = self.question.problem.title, steps.MOST_STEPS * self.coarsest
        if self.question.duration / self.coarsest > steps.MOST_STEPS:
            raise ValueError(
                f"duration must be at most {longest:g} s, which is {steps.MOST_STEPS:,} steps at {steps.COARSEST} per "
                f"period of the slowest small motion of '{title}', not {self.question.duration:g} s."
            )

    def _solve(self) -> None:
        """Find the reference of the problem and of its neighbours, and warn of what they do not cover."""
        question, problem = self.question, self.question.problem
        self.progress.report(f"solving for a reference of '{problem.title}'")
        unfinished = (
            f"the reference of '{problem.title}' was not found in {question.seconds:g} s; allow more seconds, larger "
            f"errors or a shorter duration{', or ' + KINKS if undeclared(problem.load) else ''}: {question.model[0]}."
        )
        quantities, tightest = question.quantities, question.allowed[-1]
        # functions inside the force are traced again too if what they read has changed
        with within(self.budget.end, unfinished), reading(problem.reads):
            periodic = question.given is None
            self.reference = certified(problem, question.duration, quantities, tightest, self.coarsest, periodic)
        if self.reference.horizon < question.duration:
            warn(
                f"the references of '{problem.title}' agree up to t = {self.reference.horizon:.4g} of "
                f"{question.duration:g} s: errors are measured up to this time only."
            )
        self.remarks = [*question.remarks, *remarks_on_scales(self.reference.targets)]
        with within(self.budget.end, unfinished), reading(problem.reads):
            self.cases = cases_of(problem, self.reference, quantities, tightest)
        self.with_energy = question.given is None and problem.potential is not None and not problem.dissipative
        if self.with_energy and (lack := lack_of_energy(problem, self.reference.solution)):
            warn(lack)
            self.with_energy = False

    def of_scheme(self, scheme: Scheme) -> Assessed | None:
        """Errors, verdicts, and map or limit of a scheme; None if there is no time for any run."""
        question, budget, report = self.question, self.budget, self.progress.report
        if not budget.allows("compiling"):
            return None
        coarsest = min(self.coarsest, self.duration)
        with until(budget.end):
            runs = StepSearch(scheme, self.cases, self.duration, coarsest, self.finest, self.with_energy, budget.end)
            runs.search(self.limits, lambda top: report(f"{scheme.title}: steps of {top / 2:.3g} to {top:.3g} s"))
        if not len(runs.runs):
            return None
        budget.took("compiling", runs.compiling)
        verdicts = {limit: runs.verdict(*limit) for limit in self.limits}
        recommended = np.unique([verdict.recommended for verdict in verdicts.values() if verdict.recommended > 0])
        if question.maps and not runs.late and budget.allows("map"):
            with budget.work("map"):
                map_or_limit = failures.map_of(question.problem, scheme, self.duration, self.coarsest, recommended)
        else:
            map_or_limit = failures.limit_of(question.problem, scheme, self.duration, self.coarsest)
        return Assessed(runs.runs, verdicts, map_or_limit, self._tolerances(scheme))

    def _tolerances(self, scheme: Scheme) -> dict[Limit, Verdict] | None:
        """Verdicts on controlled steps; None without a controller, or if the scheme needs equal steps."""
        controller, budget = self.question.controller, self.budget
        if controller is None or scheme.needs_equal_steps:
            return None
        search = ToleranceSearch(scheme, controller, self.cases, self.duration, self.with_energy, budget.end)
        limits = [limit for limit in self.limits if limit[0] in (*self.question.quantities, ENERGY)]
        search.late = not budget.allows("compiling control")
        with until(budget.end):
            search.search(limits, lambda top: self.progress.report(f"{scheme.title}: tolerances up to {top:.3g}"))
        budget.took("compiling control", search.compiling)
        return {limit: search.verdict(*limit) for limit in limits}

    def _remarks_on(self, results: dict[str, Assessed]) -> list[str]:
        """Remarks on final values before the end, and on your own schemes whose errors fall more slowly than stated."""
        problem, quantities = self.question.problem, self.question.quantities
        remarks = [
            f"the final value '{name}' is compared at the end of a run's last step, which may be before "
            f"{self.duration:g} s"
            for name, quantity in quantities.items()
            if quantity.reduce == "final" and any(self._ends_early(result, name) for result in results.values())
        ]
        along_time = [name for name, quantity in quantities.items() if quantity.reduce is None]
        if problem.kinked or len(getattr(problem.load, "kinks", ())) or not along_time:
            return remarks
        name, damped = along_time[0], problem.damping is not None or problem.takes_velocity
        for own in [own for own in self.question.own_schemes if own in results]:
            scheme, order = self.question.schemes[own], order_of_errors(results[own].runs, name, self.uncertainty[name])
            stated = scheme.order_with_damping if damped else scheme.order
            if order < stated - OFF_ORDER:
                remarks.append(
                    f"errors of {name} of {scheme.title} fall with the order {order:.1f}, and it states {stated}"
                )
        return remarks

    def _ends_early(self, result: Assessed, name: str) -> bool:
        """Whether a run with a recommended step of a quantity ends before the duration."""
        recommended = [verdict.recommended for limit, verdict in result.verdicts.items() if limit[0] == name]
        counts = [self.duration / step for step in recommended if step > 0]
        return any(abs(count - round(count)) > 1e-6 for count in counts)

    def dataset(self, results: dict[str, Assessed]) -> xr.Dataset:
        """The results of the schemes as a dataset."""
        question, problem, reference = self.question, self.question.problem, self.reference
        schemes = {name: question.schemes[name] for name in results}
        ds = dataset_of(problem, results, schemes, self.names, question.allowed, self.budget.end)
        if question.controller is not None:
            tolerances = {name: result.tolerances for name, result in results.items()}
            ds = ds.merge(variables_of(tolerances, self.names, question.allowed))
            ds.attrs["controller"] = question.controller.title
        ds["reference_uncertainty"] = (
            "quantity",
            [self.uncertainty[name] for name in self.names],
            {"long_name": "relative difference of the reference from its witness", "units": "1"},
        )
        ds["highest_frequency"] = (
            (),
            self.highest_frequency,
            {"long_name": "highest circular frequency of small motions about points of the motion", "units": "s-1"},
        )
        ds = with_reference(ds, measured(reference, self.with_energy, problem.conservative))
        titles = {name: quantity.long_name or name for name, quantity in (question.given or DEFAULT).items()}
        titles |= {ENERGY: "balance of energies, relative to the energy that was put in"} | oscillation.TITLES
        described = {"long_name": "description of the quantity"}
        ds = ds.assign_coords(quantity_title=("quantity", [titles[name] for name in self.names], described))
        oscillates = reference.oscillation is not None or has_a_period(problem, self.duration)
        ds.attrs |= {
            "model": "\n".join(question.model),
            "remarks": "; ".join([*self.remarks, *self._remarks_on(results)]),
            "asked_for": "; ".join(question.own_schemes),
            "reference": reference.route.name,
            "witness": reference.witness.name,
            "reference_tolerance": reference.rtol,
            "starts": sentence_on_starts(self.cases),
            "duration": self.duration,
            "duration_requested": question.duration,
            "free_vibration": int(problem.conservative and not problem.kinked and oscillates),
            "problem": problem.title,
            "command": f"study.assess(problem, {[*question.schemes]}, duration={question.duration:.17g}, "
            f"allowed_errors={question.allowed}, maps={question.maps}"
            + (", quantities=quantities)" if question.given else ")"),
            "processor": processor(),
            "not_fit": "; ".join(
                str(scheme.refusal(problem)) for name, scheme in question.schemes.items() if name not in question.fit
            ),
            **({} if question.spacing is None else {"spacing": question.spacing}),
            **record_of(problem.load),
        }
        return ds


def order_of_errors(runs: pd.DataFrame, name: str, uncertainty: float) -> float:
    """Observed order of the errors of a quantity at the finest steps, above the uncertainty of its reference.

    Other than linear theory it sees the load and a non-linear force. It is NaN if too few runs count.
    """
    runs = runs[(runs.start == 1.0) & (runs[name] < LARGE) & (runs[name] > SURE * uncertainty)]
    runs = runs[runs.dt < FINE * runs.dt.min()]
    return observed_order(1 / runs.dt.to_numpy(), runs[name].to_numpy(), least=LEAST_RUNS)


def assess_small(question: Question, progress: Progress) -> xr.Dataset:
    """Result of :func:`study.assess` for a problem with a certified reference.

    Raises
    ------
    ValueError
        If the duration has too many steps, the time ends before there is a reference and a run, or as
        :func:`study.assessment.certified.certified`.
    """
    assessment = _Assessment(question, progress)
    late = f"no scheme was run on '{question.problem.title}' in {question.seconds:g} s; allow more seconds."
    return assessment.dataset(_assess_each(question.fit, assessment.of_scheme, progress, late))


def _assess_each(
    schemes: dict[str, Scheme], function: Callable[[Scheme], Assessed | None], progress: Progress, late: str
) -> dict[str, Assessed]:
    """Results by name of the scheme; after Ctrl-C, or for lack of time, results of the finished schemes only.

    Raises
    ------
    OutOfTime
        If there was no time for any scheme; ``late`` is the message.
    """
    with progress.bar, ThreadPoolExecutor(min(cores(), len(schemes))) as pool:
        waiting = {name: pool.submit(function, scheme) for name, scheme in schemes.items()}
        try:
            for future in as_completed(waiting.values()):
                future.result()
                progress.update()
        except KeyboardInterrupt:
            progress.stopped = True
            pool.shutdown(cancel_futures=True)
    done = {
        name: future.result() for name, future in waiting.items() if not future.cancelled() and not future.exception()
    }
    results = {name: result for name, result in done.items() if result is not None}
    if not done:
        raise KeyboardInterrupt
    if not results:
        raise OutOfTime(late)
    if missing := [name for name in schemes if name not in results]:
        cause = "interrupted" if progress.stopped else "out of time"
        warn(f"{cause}: {', '.join(missing)} were not assessed.")
    return results
