"""Lyapunov exponents and mean squares of chaotic motions under a periodic load, by scheme and step size."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study.analysis.lyapunov import statistics
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, ProblemName, RisingCounts, Schemes, section
from study.experiments import coordinates
from study.problem.named import problems as problems_by_name
from study.problem.named import time_scales
from study.problem.oscillators import UEDA_EXPONENT
from study.scheme.named import schemes as schemes_by_name

#: Largest number of exponents of a problem, twice the number of its unknowns.
EXPONENTS = 6
#: Part of a run that is left out.
SKIPPED = 1 / 4


@section
class _Length(TypedDict):
    """Length of the runs in periods of the load, and number of runs with different initial displacements."""

    periods: Annotated[int, Ge(4), Le(10_000_000)]
    runs: Annotated[int, Ge(2), Le(1000)]


@section
class _Problems(TypedDict):
    ueda: _Length
    duffing_chaotic: _Length
    buckled_beam: _Length


@section
class _Chaos(TypedDict):
    problems: _Problems
    schemes: Schemes
    steps_per_period: RisingCounts


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem."""
    shared = {key: options[key] for key in ("schemes", "steps_per_period")}
    return {name: {"problem": name, **length, **shared} for name, length in options["problems"].items()}


@experiment("chaos", model=_Chaos, split=_jobs, along="problem")
def chaos(
    problem: ProblemName, schemes: Schemes, steps_per_period: RisingCounts, periods: Count, runs: Count
) -> xr.Dataset:
    """Measure Lyapunov exponents and the mean square displacement of the numerical map of a chaotic motion.

    The runs start from displacements of the first unknown that are larger by up to one, and their first quarter is left
    out. Means and standard errors are over the runs: orbits are lost after some periods, statistics need not be. A run
    is regular if its largest exponent is not positive.

    Parameters
    ----------
    steps_per_period, periods
        Steps in a period of the load, and the length of a run in periods.

    Returns
    -------
    xarray.Dataset
        Of shape (problem, scheme, steps_per_period), NaN where a run failed: ``lyapunov_exponent``, also (place), in
        descending order, ``contraction``, minus the sum of all exponents, ``mean_square`` of the first unknown, their
        standard errors, and ``regular``, the share of regular runs. ``damping`` is the contraction of the equation of
        motion.
    """
    definition, period = problems_by_name[problem], time_scales[problem]
    unknowns = np.size(definition.u0)
    u0 = np.tile(np.ravel(definition.u0), (runs, 1))
    u0[:, 0] += np.linspace(0.0, 1.0, runs)
    shape = (1, len(schemes), len(steps_per_period))
    exponents = np.full((2, *shape, EXPONENTS), np.nan)
    contraction, mean_square, regular = (
        np.full((2, *shape), np.nan),
        np.full((2, *shape), np.nan),
        np.full(shape, np.nan),
    )
    for s, scheme in enumerate(schemes):
        progress(f"chaos of {scheme} on {problem}")
        for k, steps in enumerate(steps_per_period):
            statistic = statistics(
                definition, schemes_by_name[scheme], u0, period, steps, periods, round(SKIPPED * periods)
            )
            at = 0, s, k
            if np.isfinite(statistic.exponents).all():
                exponents[:, *at, : 2 * unknowns] = _mean(statistic.exponents)
                contraction[:, *at] = _mean(-statistic.exponents.sum(axis=1))
                mean_square[:, *at] = _mean(statistic.mean_square[:, 0])
                regular[at] = np.mean(statistic.exponents[:, 0] <= 0)
    dims, error = ("problem", "scheme", "steps_per_period"), "standard error of the"
    damping = float(np.trace(np.broadcast_to(definition.damping, (unknowns, unknowns)) * np.eye(unknowns)))
    return xr.Dataset(
        {
            "lyapunov_exponent": ((*dims, "place"), exponents[0], {"long_name": "Lyapunov exponent", "units": "s-1"}),
            "lyapunov_exponent_uncertainty": (
                (*dims, "place"),
                exponents[1],
                {"long_name": f"{error} exponent", "units": "s-1"},
            ),
            "contraction": (dims, contraction[0], {"long_name": "minus the sum of the exponents", "units": "s-1"}),
            "contraction_uncertainty": (dims, contraction[1], {"long_name": f"{error} contraction", "units": "s-1"}),
            "mean_square": (
                dims,
                mean_square[0],
                {"long_name": "mean square displacement, first unknown", "units": "1"},
            ),
            "mean_square_uncertainty": (dims, mean_square[1], {"long_name": f"{error} mean square", "units": "1"}),
            "regular": (dims, regular, {"long_name": "share of runs without a positive exponent", "units": "1"}),
            "damping": ("problem", [damping], {"long_name": "contraction of the equation of motion", "units": "s-1"}),
            "printed_exponent": (
                "problem",
                [UEDA_EXPONENT if problem == "ueda" else np.nan],
                {"long_name": "exponent of Sprott (2003)", "units": "s-1"},
            ),
            "period": ("problem", [period], {"long_name": "period of the load", "units": "s"}),
        },
        coords={
            **coordinates.problem_coordinates([problem]),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "place": (
                "place",
                np.arange(EXPONENTS),
                {"long_name": "place of the exponent in descending order", "units": "1"},
            ),
            "periods": ("problem", [periods], {"long_name": "length of the runs in periods", "units": "1"}),
            "runs": ("problem", [runs], {"long_name": "number of runs", "units": "1"}),
        },
        attrs={"title": "Lyapunov exponents and mean squares of chaotic motions by scheme and step"},
    )


def _mean(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean over the runs, along the first axis, and its standard error."""
    return values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))
