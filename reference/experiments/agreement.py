"""True errors of every route at every tolerance, over one, ten and a hundred periods."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from reference import diffrax, exact, sundials, taylor
from reference.solution import RouteFailed, Solution, StepLimit, Times, Windowed
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import FallingTolerances, Springs, section
from study.io import flags
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name

#: Two functions of every route. The first takes a problem, times and a tolerance, and returns the trajectory. The
#: second takes a problem, a rough period and a tolerance, and returns the period.
ROUTES: dict[str, tuple[Callable, Callable]] = {
    "cvode_adams": (partial(sundials.trajectory, method="Adams"), partial(sundials.period, method="Adams")),
    "cvode_bdf": (partial(sundials.trajectory, method="BDF"), partial(sundials.period, method="BDF")),
    "dopri8": (partial(diffrax.trajectory, method="Dopri8"), partial(diffrax.period, method="Dopri8")),
    "tsit5": (partial(diffrax.trajectory, method="Tsit5"), partial(diffrax.period, method="Tsit5")),
    # the number of steps is limited, because this implicit method may take minutes for a hundred periods
    "kvaerno5": (
        partial(diffrax.trajectory, method="Kvaerno5", max_steps=30_000),
        partial(diffrax.period, method="Kvaerno5"),
    ),
    "heyoka": (taylor.trajectory, taylor.period),
}
FINISHED, STEP_LIMIT, FAILED, NOT_TRIED, LOST = range(5)
STATUS_MEANINGS = ("finished", "step_limit", "failed", "not_tried", "lost")
#: Error of the displacement, relative to its largest value, above which a solution counts as lost.
LOST_ABOVE = 10
#: Number of samples in a period; samples only at whole periods would hide an error of the phase.
SAMPLES = 16
#: Lengths, in periods, of the windows over which the largest errors are taken.
WINDOWS = (1, 10, 100)


def instants(period: float) -> Times:
    """Times at which the routes are compared with the exact solution: k T/16 up to the end of the longest window."""
    return np.arange(1, max(WINDOWS) * SAMPLES + 1) * period / SAMPLES


def errors(exact_solution: exact.ExactSolution, solution: Solution) -> dict[str, Windowed]:
    r"""Largest error :math:`\max|\Delta u|/\max|u|` up to the end of every window, and at whole periods alone."""
    error = np.abs(solution.u - exact_solution.u) / np.max(np.abs(exact_solution.u))
    # the velocity is zero at whole periods, so a delay causes no displacement error of first order there
    at_periods = error[SAMPLES - 1 :: SAMPLES]
    return {
        "displacement_error": np.array([np.max(error[: w * SAMPLES]) for w in WINDOWS]),
        "displacement_error_at_periods": np.array([np.max(at_periods[:w]) for w in WINDOWS]),
    }


def _attempt(solve: Callable, *arguments):
    """Result of a route, or ``None`` if it failed, and the status of the attempt."""
    try:
        return solve(*arguments), FINISHED
    except RouteFailed as failure:
        progress(str(failure))
        return None, STEP_LIMIT if isinstance(failure, StepLimit) else FAILED


@section
class _Agreement(TypedDict):
    tolerances: FallingTolerances


def _options(configuration: Mapping) -> Options:
    return {"problems": configuration["references"]["problems"], **configuration["agreement"]}


# one job for all springs, because the tracing of diffrax takes longer than its runs
@experiment("reference_agreement", section="agreement", model=_Agreement, options=_options)
def agreement(problems: Springs, tolerances: Sequence[float]) -> xr.Dataset:
    """Measure the true errors of every reference solver at every tolerance.

    Once a route reaches the limit of steps, its trajectory is not computed at tighter tolerances. The errors of the
    trajectory have the shape (problem, route, tolerance, periods). They are NaN if the trajectory did not finish;
    ``status`` states the reason. The error of the period has the shape (problem, route, tolerance).

    Raises
    ------
    ValueError
        If the tolerances are not in descending order.
    """
    if list(tolerances) != sorted(tolerances, reverse=True):
        raise ValueError(f"the tolerances must be in descending order, not {tolerances}.")
    parts = [_problem_dataset(problem, tolerances) for problem in problems]
    return xr.concat(parts, "problem", data_vars="minimal", coords="minimal")


def _problem_dataset(problem: str, tolerances: Sequence[float]) -> xr.Dataset:
    definition, estimate = problems_by_name[problem], approximate_periods[problem]
    shape = (len(ROUTES), len(tolerances))
    windowed = {
        name: np.full((*shape, len(WINDOWS)), np.nan)
        for name in ("displacement_error", "displacement_error_at_periods")
    }
    period_error, status = np.full(shape, np.nan), np.full(shape, NOT_TRIED, np.int32)
    exact_period, certified = exact.period(definition, estimate)
    t = instants(float(exact_period))
    exact_solution = exact.folded(definition, t, exact_period, certified)
    for r, (route, (trajectory, period)) in enumerate(ROUTES.items()):
        progress(f"{route} on {problem}")
        for k, tolerance in enumerate(tolerances):
            index = r, k
            value, _ = _attempt(period, definition, estimate, tolerance)
            if value is not None:
                period_error[index] = abs(value / float(exact_period) - 1)
            if STEP_LIMIT in status[r, :k]:
                continue
            solution, status[index] = _attempt(trajectory, definition, t, tolerance)
            if solution is not None:
                for quantity, values in errors(exact_solution, solution).items():
                    windowed[quantity][index] = values
                if windowed["displacement_error"][index].max() > LOST_ABOVE:
                    status[index] = LOST
    dims = ("route", "tolerance")
    descriptions = {
        "displacement_error": "largest error of the displacement, relative to its largest size",
        "displacement_error_at_periods": "largest error of the displacement at whole periods, over its largest size",
    }
    return xr.Dataset(
        {
            **{
                name: ((*dims, "periods"), values, {"long_name": descriptions[name], "units": "1"})
                for name, values in windowed.items()
            },
            "period_error": (dims, period_error, {"long_name": "relative error of the period", "units": "1"}),
            "status": (dims, status, flags("how the trajectory ended", STATUS_MEANINGS, np.int32)),
        },
        coords={
            "problem": ((), problem, {"long_name": "problem"}),
            "route": ("route", list(ROUTES), {"long_name": "solver of the trajectory"}),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "prescribed relative tolerance", "units": "1"}),
            "periods": (
                "periods",
                list(WINDOWS),
                {"long_name": "periods over which the largest error is taken", "units": "1"},
            ),
        },
        attrs={"title": "What a tolerance delivers: true errors of the reference solvers"},
    ).expand_dims("problem")
