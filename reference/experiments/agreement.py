"""True errors of every route at every tolerance, over one, ten and a hundred periods."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import jax
import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from reference import diffrax, exact, sundials, taylor
from reference.solution import RouteFailed, Solution, StepLimit, Times, Windowed
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import FallingTolerances, Springs, section
from study.io import flags
from study.mechanics.definition import Problem
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


def errors(problem: Problem, exact_solution: exact.ExactSolution, solution: Solution) -> dict[str, Windowed]:
    r"""Largest errors up to the end of every window, each (windows,).

    The errors of displacement, velocity and energy are :math:`\max|\Delta u|/\max|u|`,
    :math:`\max|\Delta\dot u|/\max|\dot u|` and :math:`\max|E/E_0 - 1|`. The error of the displacement is also given at
    whole periods alone.
    """
    energy = np.asarray(jax.vmap(problem.energy)(solution.u, solution.v))
    initial = float(problem.energy(np.asarray(problem.u0), np.asarray(problem.v0)))
    histories = {
        "displacement_error": np.abs(solution.u - exact_solution.u) / np.max(np.abs(exact_solution.u)),
        "velocity_error": np.abs(solution.v - exact_solution.v) / np.max(np.abs(exact_solution.v)),
        "energy_error": np.abs(energy / initial - 1),
    }
    largest = {name: np.array([np.max(h[: w * SAMPLES]) for w in WINDOWS]) for name, h in histories.items()}
    # the velocity is zero at whole periods, so a delay causes no displacement error of first order there
    at_periods = histories["displacement_error"][SAMPLES - 1 :: SAMPLES]
    return largest | {"displacement_error_at_periods": np.array([np.max(at_periods[:w]) for w in WINDOWS])}


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
    """Measure the true errors and the effort of every reference solver at every tolerance.

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
        for name in ("displacement_error", "velocity_error", "energy_error", "displacement_error_at_periods")
    }
    single = {name: np.full(shape, np.nan) for name in ("period_error", "evaluations", "seconds")}
    statuses = {name: np.full(shape, NOT_TRIED, np.int32) for name in ("status", "period_status")}
    exact_period, certified = exact.period(definition, estimate)
    t = instants(float(exact_period))
    exact_solution = exact.folded(definition, t, exact_period, certified)
    for r, (route, (trajectory, period)) in enumerate(ROUTES.items()):
        progress(f"{route} on {problem}")
        for k, tolerance in enumerate(tolerances):
            index = r, k
            value, statuses["period_status"][index] = _attempt(period, definition, estimate, tolerance)
            if value is not None:
                single["period_error"][index] = abs(value / float(exact_period) - 1)
            if STEP_LIMIT in statuses["status"][r, :k]:
                continue
            solution, statuses["status"][index] = _attempt(trajectory, definition, t, tolerance)
            if solution is not None:
                single["evaluations"][index], single["seconds"][index] = solution.evaluations, solution.seconds
                for quantity, values in errors(definition, exact_solution, solution).items():
                    windowed[quantity][index] = values
                if windowed["displacement_error"][index].max() > LOST_ABOVE:
                    statuses["status"][index] = LOST
    dims = ("route", "tolerance")
    descriptions = {
        "displacement_error": "largest error of the displacement, relative to its largest size",
        "velocity_error": "largest error of the velocity, relative to its largest size",
        "energy_error": "largest relative error of the energy",
        "displacement_error_at_periods": "largest error of the displacement at whole periods, over its largest size",
        "period_error": "relative error of the period",
        "evaluations": f"evaluations of the right side over {max(WINDOWS)} periods; for kvaerno5 the stages, each with "
        "several evaluations; for heyoka the Taylor coefficients; for CVODE without evaluations for the Jacobian",
        "seconds": f"run time over {max(WINDOWS)} periods, without compilation, of one run while other jobs run",
        "status": "how the trajectory ended",
        "period_status": "how the search for the period ended",
    }
    variables = {
        name: ((*dims, "periods"), values, {"long_name": descriptions[name], "units": "1"})
        for name, values in windowed.items()
    } | {
        name: (dims, values, {"long_name": descriptions[name], "units": "s" if name == "seconds" else "1"})
        for name, values in single.items()
    }
    return xr.Dataset(
        variables
        | {
            name: (dims, values, flags(descriptions[name], STATUS_MEANINGS, np.int32))
            for name, values in statuses.items()
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
