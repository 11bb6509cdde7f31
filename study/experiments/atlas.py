"""Maps of stability: how the runs of a scheme end, over step size and amplitude.

A job makes one tile of the maps, which is a range of amplitudes for one scheme. It also keeps samples of some of its
runs. Both come from one march, because compiling a second one takes as long as running it.
"""

import math
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
from study.marching.run import run
from study.observer.crossings import Oscillations
from study.observer.outcome import Height, OutcomeObserver
from study.problem.named import problems as problems_by_name

#: Part of a period by which consecutive samples move around an orbit, as nearly as the steps allow. The golden section
#: is the number that fractions approximate worst, so the samples spread over the whole orbit.
GOLDEN = (5**0.5 - 1) / 2

#: Part of a period between two samples of the beginning of a run, at most, unless its steps are longer.
EARLY = 1 / 20


def _prime(most: int) -> int:
    """The largest prime that is at most ``most``, which is at least 2."""
    return next(n for n in range(most, 1, -1) if all(n % d for d in range(2, math.isqrt(n) + 1)))


def _single(values: np.ndarray) -> np.ndarray:
    """Values in single precision; those that overflow become infinite."""
    with np.errstate(over="ignore"):
        return values.astype(np.float32)


def _column(runs: xr.Dataset, dt: np.ndarray, period: np.ndarray) -> dict[str, np.ndarray]:
    """Variables of the maps at one step size, each (amplitudes,), out of the ensemble of its runs."""
    outcome, began = outcomes(runs, period)
    step = np.where(np.isnan(began), -1, np.rint(began / dt))
    return {
        "outcome": outcome,
        "at_step": np.where(runs.status > 0, runs.failed_at_step, step).astype(np.int32),
        "max_energy_error": _single(runs.max_height_error.values),
        "period_error": _single(100 * np.abs(runs.mean_period.values / period - 1)),
        "max_newton_iterations": _single(runs.max_newton_iterations.values),
        "lyapunov_exponent": _single(runs.lyapunov_exponent.values),
    }


def _sampled(places: np.ndarray, whole: int, points: int) -> np.ndarray:
    """Whether samples are kept at each of some places (m,), which lie on an axis of ``whole`` places.

    They are kept at evenly spaced places, at most ``points`` on the whole axis.
    """
    return places % -(-whole // points) == 0


@section
class _Portraits(TypedDict):
    points: Count
    samples: Count


@section
class _Atlas(TypedDict):
    problems: Springs
    schemes: Schemes
    amplitudes: PowersOfTen
    dt_over_period: PowersOfTen
    periods: Count
    portraits: _Portraits
    tiles: Count


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each scheme and tile."""
    shared = {key: options[key] for key in ("problems", "dt_over_period", "periods", "portraits", "tiles")}
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
        return f"tiles: there are more of them, {tiles}, than amplitudes, {amplitudes}."
    return step_beyond_run(10 ** options["dt_over_period"]["last"], options["periods"])


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    first, last, count = (options["dt_over_period"][key] for key in ("first", "last", "count"))
    # at most 100 step sizes are summed; more of them scale the sum
    of_amplitude = np.sum(options["periods"] / np.logspace(first, last, min(count, 100))) * max(count / 100, 1)
    return len(options["problems"]) * of_amplitude * _number_of_amplitudes(configuration) / options["tiles"]


def _numbers_held(options: Options, configuration: Mapping) -> float:
    points, samples = options["portraits"]["points"], options["portraits"]["samples"]
    amplitudes = _number_of_amplitudes(configuration)
    on_maps = amplitudes * options["dt_over_period"]["count"]
    # all amplitudes of a tile are run at once: three values at every sample, and two at every step of the beginning
    early = max(1.0, EARLY / 10 ** options["dt_over_period"]["first"])
    at_once = -(-amplitudes // options["tiles"]) * samples * (3 + 2 * early)
    return at_once + len(options["problems"]) * (8 * on_maps + 5 * points**2 * samples)


@experiment(
    "stability/atlas",
    "stability/portraits",
    section="atlas",
    model=_Atlas,
    split=_jobs,
    along="scheme,amplitude",
    parts=("stability/tiles", "stability/portraits"),
    reads=lambda options: ["reference/amplitudes"],
    check=_check,
    steps=_number_of_steps,
    values=_numbers_held,
)
def atlas(
    scheme: SchemeName,
    problems: Springs,
    dt_over_period: dict[str, float],
    periods: int,
    portraits: dict[str, int],
    tile: int,
    tiles: int,
) -> tuple[xr.Dataset, xr.Dataset]:
    """Find how the runs of a scheme end, over step size and amplitude.

    The amplitudes of ``results/reference/amplitudes`` are split into ``tiles`` parts, of which one is computed.

    Parameters
    ----------
    dt_over_period
        ``count`` values of Δt/T, from 10 to the power ``first`` to 10 to the power ``last``; T is the exact period at
        each amplitude.
    periods
        Length of the runs in periods T.
    portraits
        ``points`` is the largest number of amplitudes, and of step sizes, at which samples are kept; ``samples`` is
        the number of samples after the first, of the whole run and of its beginning.
    tile
        Number of the part, from 0 on.

    Returns
    -------
    maps, samples : xarray.Dataset
        Variables of shape (scheme, problem, amplitude, dt_over_period), and of the samples also (..., sample).
        ``early_u`` and ``early_v`` are samples of the first periods, at most T/20 or a step apart, so that a line
        through them is the orbit; the others are spread over the whole run.

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
    own = np.array_split(np.arange(exact.sizes["amplitude"]), tiles)[tile]
    sampled = _sampled(own, exact.sizes["amplitude"], portraits["points"])
    exact = exact.isel(amplitude=own)
    parts = np.logspace(dt_over_period["first"], dt_over_period["last"], int(dt_over_period["count"]))
    sampled_parts = _sampled(np.arange(len(parts)), len(parts), portraits["points"])
    spacing = GOLDEN + max(0, round(periods / portraits["samples"] - GOLDEN))
    # a prime number of steps: on an orbit that closes after some steps, samples could otherwise all fall on one point;
    # at least two, because a sample at every step would be another program
    every = np.array([_prime(max(2, round(spacing / part))) for part in parts])
    # the beginning is marched with a sample at every step, which one program does for all step sizes, and then thinned
    early_every = np.maximum(1, (EARLY / parts + 1e-9).astype(int))
    early_steps = int(portraits["samples"] * early_every[sampled_parts].max())
    maps: dict[str, list] = {}
    samples: dict[str, list] = {}
    for problem in problems:
        progress(f"stability of {scheme} on {problem}")
        definition, of_problem = problems_by_name[problem], exact.sel(problem=problem)
        u0, period, observer = of_problem.u0.values, of_problem.period.values, OutcomeObserver.of(definition)
        for part, apart, early_apart, is_sampled in zip(parts, every, early_every, sampled_parts, strict=True):
            runs = run(
                definition,
                scheme,
                dt=part * period,
                steps=round(periods / part),
                u0=u0,
                observe=[
                    observer,
                    Oscillations(observer.rest_at),
                    "lyapunov_exponent",
                    "trajectory",
                    Height(observer.rest),
                ],
                every=int(apart),
                samples=portraits["samples"],
                on_failure="ignore",
            )
            for variable, column in _column(runs, part * period, period).items():
                maps.setdefault(variable, []).append(column)
            if not is_sampled:
                continue
            begun = run(
                definition,
                scheme,
                dt=part * period,
                steps=min(early_steps, round(periods / part)),
                u0=u0,
                samples=early_steps,
                on_failure="ignore",
            )
            early = {f"early_{name}": begun[name][:, :: int(early_apart)] for name in ("u", "v")}
            for variable, values in {**{name: runs[name] for name in ("u", "v", "height")}, **early}.items():
                chosen = values.values[sampled, : portraits["samples"] + 1]
                samples.setdefault(variable, []).append(_single(chosen))
    dims = ("problem", "amplitude", "dt_over_period")
    attributes = {
        "outcome": {**OUTCOME_ATTRIBUTES, "flag_explanations": "; ".join(EXPLANATIONS)},
        "at_step": {
            "long_name": "step at which it began, -1 where the run is accurate or only its period is wrong",
            "units": "1",
        },
        "max_energy_error": {
            "long_name": "largest error of the energy over its height above rest, NaN where the run failed",
            "units": "percent",
        },
        "period_error": {
            "long_name": "relative error of the mean period, NaN where there is none",
            "units": "percent",
        },
        "max_newton_iterations": {
            "long_name": "most Newton iterations in one step, NaN where the run failed",
            "units": "1",
        },
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
        "early_u": {"long_name": "displacement in the first periods", "units": "1"},
        "early_v": {"long_name": "velocity in the first periods", "units": "s-1"},
    } | {name: runs[name].attrs for name in ("u", "v", "height")}

    def labelled(found, exact, parts, title, *along):
        """A dataset out of lists of columns, one for each problem and step size: amplitudes before step sizes."""
        shape = (len(problems), len(parts))
        values = {name: np.stack(columns).reshape(*shape, *columns[0].shape) for name, columns in found.items()}
        return (
            xr.Dataset(
                {name: ((*dims, *along), np.moveaxis(v, 1, 2), attributes[name]) for name, v in values.items()},
                coords={
                    **coordinates.problem_coordinates(problems),
                    "amplitude": exact.amplitude,
                    "u0": exact.u0,
                    "period": exact.period,
                    "highest_frequency": exact.highest_frequency,
                    "dt_over_period": ("dt_over_period", parts, {"long_name": "step size over period", "units": "1"}),
                    "periods": ((), periods, {"long_name": "length of the runs in periods", "units": "1"}),
                },
                attrs={"title": title},
            )
            .expand_dims("scheme")
            .assign_coords(coordinates.scheme_coordinates([scheme]))
        )

    portrait = labelled(
        samples,
        exact.isel(amplitude=sampled),
        parts[sampled_parts],
        f"Samples of {periods} periods with every scheme, over step size and amplitude",
        "sample",
    )
    return (
        labelled(
            maps, exact, parts, f"What becomes of {periods} periods with every scheme, over step size and amplitude"
        ),
        portrait.assign_coords(
            every=("dt_over_period", every[sampled_parts], {"long_name": "steps between two samples", "units": "1"}),
            early_every=(
                "dt_over_period",
                early_every[sampled_parts],
                {"long_name": "steps between two samples of the first periods", "units": "1"},
            ),
        ),
    )
