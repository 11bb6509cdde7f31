"""Maps of stability: how the runs of a scheme end, over step size and amplitude.

A job makes one tile of the maps: a range of amplitudes for one scheme.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.analysis.outcomes import EXPLANATIONS, OUTCOME_ATTRIBUTES, outcomes
from study.declaration.checks import step_beyond_run
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, PowersOfTen, SchemeName, Schemes, Springs, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.crossings import Oscillations
from study.observer.outcome import OutcomeObserver
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name


def _single(values: np.ndarray) -> np.ndarray:
    """Values in single precision; a value that overflows becomes infinite."""
    with np.errstate(over="ignore"):
        return values.astype(np.float32)


def _column(runs: xr.Dataset, dt: np.ndarray, period: np.ndarray, beyond: np.ndarray) -> dict[str, np.ndarray]:
    """Variables of the maps at one value of Δt/T, each (amplitudes,), from the ensemble of the runs with this value."""
    outcome, began = outcomes(runs, period, beyond)
    step = np.where(np.isnan(began), -1, np.rint(began / dt))
    return {
        "outcome": outcome,
        "at_step": np.where(runs.status > 0, runs.failed_at_step, step).astype(np.int32),
        "max_energy_error": _single(runs.max_height_error.values),
        "period_error": _single(np.abs(runs.mean_period.values / period - 1)),
        "max_newton_iterations": _single(runs.max_newton_iterations.values),
        "lyapunov_exponent": _single(runs.lyapunov_exponent.values),
    }


@section
class _Atlas(TypedDict):
    problems: Springs
    schemes: Schemes
    amplitudes: PowersOfTen
    step_size_over_period: PowersOfTen
    periods: Count
    tiles: Count


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each scheme and tile."""
    shared = {key: options[key] for key in ("problems", "step_size_over_period", "periods", "tiles")}
    return {
        f"{scheme}_{tile}": {"scheme": scheme, "tile": tile, **shared}
        for scheme in options["schemes"]
        for tile in range(options["tiles"])
    }


def _number_of_amplitudes(configuration: Mapping) -> int:
    return configuration["atlas"]["amplitudes"]["count"]


def _check(options: Options, configuration: Mapping) -> str | None:
    tiles, amplitudes = options["tiles"], _number_of_amplitudes(configuration)
    if tiles > amplitudes:
        return f"tiles: {tiles} tiles are more than the {amplitudes} amplitudes."
    return step_beyond_run(10 ** options["step_size_over_period"]["last"], options["periods"])


@experiment(
    "stability/atlas",
    section="atlas",
    model=_Atlas,
    split=_jobs,
    along="scheme,amplitude",
    parts=("stability/tiles",),
    reads=lambda options: ["reference/amplitudes"],
    check=_check,
)
def atlas(
    scheme: SchemeName,
    problems: Springs,
    step_size_over_period: dict[str, float],
    periods: int,
    tile: int,
    tiles: int,
) -> xr.Dataset:
    """Find how the runs of a scheme end, over step size and amplitude.

    The amplitudes of ``results/reference/amplitudes`` are split into ``tiles`` parts. The function computes one part.

    Parameters
    ----------
    step_size_over_period
        ``count`` values of Δt/T, from 10 to the power ``first`` to 10 to the power ``last``; T is the exact period at
        each amplitude.
    periods
        Length of the runs in periods T.
    tile
        Number of the part, counted from 0.

    Returns
    -------
    xarray.Dataset
        Variables of shape (scheme, problem, amplitude, step_size_over_period).

    Raises
    ------
    ValueError
        If ``tile`` is not one of the parts.
    FileNotFoundError
        If ``results/reference/amplitudes.nc`` has not been made.
    """
    if not 0 <= tile < tiles:
        raise ValueError(f"there is no tile {tile} among {tiles}: the first is 0, the last {tiles - 1}.")
    exact = io.open_dataset("reference/amplitudes").sel(problem=list(problems))
    amplitudes = np.array_split(np.arange(exact.sizes["amplitude"]), tiles)[tile]
    exact = exact.isel(amplitude=amplitudes)
    parts = np.logspace(
        step_size_over_period["first"], step_size_over_period["last"], int(step_size_over_period["count"])
    )
    maps: dict[str, list] = {}
    limit = schemes_by_name[scheme].stability_limit or np.inf  # a limit of zero is that of a weak instability
    for problem in problems:
        progress(f"stability of {scheme} on {problem}")
        definition, motions = problems_by_name[problem], exact.sel(problem=problem)
        u0, period, observer = motions.u0.values, motions.period.values, OutcomeObserver.of(definition)
        longest = limit / motions.highest_frequency.values
        for part in parts:
            runs = sweep(
                definition,
                scheme,
                dt=part * period,
                steps=round(periods / part),
                u0=u0,
                observe=[observer, Oscillations(observer.rest_at), "lyapunov_exponent"],
            )
            for variable, column in _column(runs, part * period, period, part * period > longest).items():
                maps.setdefault(variable, []).append(column)
    dims = ("problem", "amplitude", "step_size_over_period")
    attributes = {
        "outcome": {**OUTCOME_ATTRIBUTES, "flag_explanations": "; ".join(EXPLANATIONS)},
        "at_step": {
            "long_name": "step at which the outcome began, -1 if the run is accurate or only its period is wrong",
            "units": "1",
        },
        "max_energy_error": {
            "long_name": "largest error of the energy over its height above rest, NaN where the run failed",
            "units": "1",
        },
        "period_error": {
            "long_name": "relative error of the mean period, NaN where the run has no period",
            "units": "1",
        },
        "max_newton_iterations": {
            "long_name": "most Newton iterations in one step, NaN where the run failed",
            "units": "1",
        },
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
    }
    values = {name: np.stack(columns).reshape(len(problems), len(parts), -1) for name, columns in maps.items()}
    return (
        xr.Dataset(
            {name: (dims, np.moveaxis(v, 1, 2), attributes[name]) for name, v in values.items()},
            coords={
                **coordinates.problem_coordinates(problems),
                "amplitude": exact.amplitude,
                "u0": exact.u0,
                "period": exact.period,
                "highest_frequency": exact.highest_frequency,
                "step_size_over_period": (
                    "step_size_over_period",
                    parts,
                    {"long_name": "step size over period", "units": "1"},
                ),
                "periods": ((), periods, {"long_name": "length of the runs in periods", "units": "1"}),
            },
            attrs={"title": f"Outcome of {periods} periods with every scheme, over step size and amplitude"},
        )
        .expand_dims("scheme")
        .assign_coords(
            coordinates.scheme_coordinates([scheme]) | coordinates.forces_coordinates([scheme], several=False)
        )
    )
