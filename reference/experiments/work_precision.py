"""Work and precision of general solvers, which ``results/work_precision.nc`` compares with the schemes."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Gt, Le

from reference import diffrax, exact, scipy, sundials, taylor
from reference.experiments.agreement import FINISHED, LOST, LOST_ABOVE, NOT_TRIED, STATUS_MEANINGS
from reference.solution import RouteFailed, Solution
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import FallingTolerances, Repeats, RisingCounts, Springs
from study.io import flags
from study.problem.named import approximate_periods
from study.problem.named import problems as problems_by_name

#: Trajectory of every solver: a function of problem, times and tolerance.
SOLVERS: dict[str, Callable[..., Solution]] = {
    "cvode_adams": partial(sundials.trajectory, method="Adams"),
    "cvode_bdf": partial(sundials.trajectory, method="BDF"),
    "dopri8": partial(diffrax.trajectory, method="Dopri8"),
    "tsit5": partial(diffrax.trajectory, method="Tsit5"),
    "kvaerno5": partial(diffrax.trajectory, method="Kvaerno5"),
    "scipy_dop853": partial(scipy.trajectory, method="DOP853"),
    "scipy_radau": partial(scipy.trajectory, method="Radau"),
    "heyoka": taylor.trajectory,
}
#: Whether the right side of a solver is Python or compiled.
RIGHT_SIDES = {
    "cvode_adams": "Python",
    "cvode_bdf": "Python",
    "scipy_dop853": "Python",
    "scipy_radau": "Python",
    "heyoka": "compiled",
    "dopri8": "compiled",
    "tsit5": "compiled",
    "kvaerno5": "compiled",
}
#: Lengths of the runs in periods. Results at other lengths come from the beginning of a run.
RUNS = (100, 1000)
#: Template for the long name of a cost.
SHARE = "{} of a run; for a shorter length its proportional share"
#: Number of samples in the last period of each length, at which errors are measured.
SAMPLES = 16


def _repeated(solve: Callable[[], Solution], repeats: int, longest: float) -> list[Solution]:
    """Solutions of up to ``repeats`` equal runs. No run begins after ``longest`` seconds or a failure."""
    runs: list[Solution] = []
    try:
        while len(runs) < repeats and sum(run.seconds for run in runs) < longest:
            runs.append(solve())
    except RouteFailed as failure:
        progress(str(failure))
    return runs


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse problems and lengths for which the schemes are not run.

    Tolerances that are too tight, and lengths without the shortest run, are refused too.
    """
    allowed = configuration["work_precision"]["schemes"]["problems"]
    refused = unlisted("problems", options["problems"], "work_precision.schemes.problems", allowed)
    if refused is not None:
        return refused
    tightest = min(options["tolerances"])
    if tightest < scipy.SMALLEST_RTOL:
        return f"tolerances must be at least {scipy.SMALLEST_RTOL:.1e}, the smallest of SciPy, not {tightest}."
    if min(RUNS) not in options["periods"]:
        return f"periods lacks {min(RUNS)}, the length of the shortest run."
    return unlisted("periods", options["periods"], "accuracy.periods", configuration["accuracy"]["periods"])


@experiment("work_precision/solvers", check=_check, timed=True, temporary=True)
def work_precision(
    problems: Springs,
    tolerances: FallingTolerances,
    periods: RisingCounts,
    repeats: Repeats,
    longest: Annotated[float, Gt(0), Le(3600)],
) -> xr.Dataset:
    """Measure time and evaluations of every general solver at every tolerance, and its error of the displacement.

    Runs have 100 and 1,000 periods. A shorter length is the beginning of a run, with a proportional part of its time
    and evaluations. The error is the largest in the last period of each length, where growing errors are the largest.
    A run is made up to ``repeats`` times, and no repeat begins after ``longest`` seconds. A run of 1,000 periods is
    left out (NaN) if it would take more than ``longest`` seconds, judged by the run of 100 periods. If a run fails, or
    100 periods take more than ``longest`` seconds, all tighter tolerances are left out (NaN).

    Variables of the solvers have the shape (problem, solver, tolerance, periods).

    Parameters
    ----------
    repeats, longest
        Largest number of times that a run is made, and the time in seconds after which no repeat begins.
    """
    shape = tuple(map(len, (problems, SOLVERS, tolerances, periods)))
    error, evaluations = np.full(shape, np.nan), np.full(shape, np.nan)
    seconds = np.full((*shape, repeats), np.nan)
    status = np.full(shape, NOT_TRIED, np.int32)
    for p, problem in enumerate(problems):
        definition = problems_by_name[problem]
        exact_period, certified = exact.period(definition, approximate_periods[problem])
        period = float(exact_period)
        last = np.arange(1, SAMPLES + 1) / SAMPLES - 1
        t = period * np.concatenate([length + last for length in sorted(periods)])
        known = exact.folded(definition, t, exact_period, certified).u
        for s, (solver, trajectory) in enumerate(SOLVERS.items()):
            progress(f"{solver} on {problem}")
            for k, tolerance in enumerate(tolerances):
                for length in (length for length in RUNS if length in periods):
                    shorter = [window for window in periods if window <= length]
                    times = t[: len(shorter) * SAMPLES]
                    runs = _repeated(partial(trajectory, definition, times, tolerance), repeats, longest)
                    for w, window in enumerate(shorter if runs else []):
                        index, part = (p, s, k, w), slice(w * SAMPLES, (w + 1) * SAMPLES)
                        seconds[index][: len(runs)] = [run.seconds * window / length for run in runs]
                        evaluations[index] = runs[0].evaluations * window / length
                        error[index] = np.abs(runs[0].u[part] - known[part]).max() / np.abs(known[part]).max()
                        status[index] = LOST if error[index] > LOST_ABOVE else FINISHED
                    if not runs or runs[0].seconds * max(RUNS) / length > longest:
                        break
                if not runs or runs[0].seconds * min(RUNS) / length > longest:
                    break
    dims = ("problem", "solver", "tolerance", "periods")
    return xr.Dataset(
        {
            "solver_last_period_error": (
                dims,
                error,
                {"long_name": "largest error of the displacement in the last period, relative", "units": "1"},
            ),
            "solver_seconds": ((*dims, "solver_repeat"), seconds, {"long_name": SHARE.format("time"), "units": "s"}),
            "median_solver_seconds": (
                dims,
                np.ma.median(np.ma.masked_invalid(seconds), axis=-1).filled(np.nan),
                {"long_name": SHARE.format("median time"), "units": "s"},
            ),
            "solver_status": (dims, status, flags("how the run ended", STATUS_MEANINGS, np.int32)),
            "solver_force_evaluations": (
                dims,
                evaluations,
                {
                    "long_name": SHARE.format("evaluations of the right side")
                    + "; for kvaerno5 the stages, each with several "
                    "evaluations; for heyoka the Taylor coefficients; for CVODE without evaluations for the Jacobian",
                    "units": "1",
                },
            ),
        },
        coords={
            "problem": ("problem", list(problems), {"long_name": "problem"}),
            "solver": ("solver", list(SOLVERS), {"long_name": "adaptive solver"}),
            "right_side": (
                "solver",
                [RIGHT_SIDES[solver] for solver in SOLVERS],
                {"long_name": "form of the right side, which takes most of the time if it is Python"},
            ),
            "tolerance": ("tolerance", list(tolerances), {"long_name": "prescribed relative tolerance", "units": "1"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
        },
        attrs={"title": "Work and precision of general solvers"},
    )
