"""Where a scheme can be trusted and how it fails where it cannot, over step size and amplitude: one tile of the maps.

Samples of some of the runs are kept beside the maps. They come from the same march: to compile another one would take
as long as to run it.
"""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import datasets
from study.analysis.outcomes import OUTCOME_ATTRIBUTES, outcomes
from study.equilibrium.newton import MAX_ITERATIONS
from study.marching.result import NEWTON_FAILED
from study.marching.run import run
from study.observer.fate import Fate, Height
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import MULTI_OUTPUT_FUSION, experiment
from study.pipeline.options import Count, PowersOfTen, Schemes, Springs, section
from study.problem.named import problems as registry

#: The part of a period by which samples move around an orbit, as nearly as steps allow: the golden section is furthest
#: from every fraction, so that they come to lie all around it.
GOLDEN = (5**0.5 - 1) / 2


def _prime(most: int) -> int:
    """The largest prime up to a number of at least 2."""
    return next(n for n in range(most, 1, -1) if all(n % d for d in range(2, math.isqrt(n) + 1)))


def _single(values: np.ndarray) -> np.ndarray:
    """In single precision, infinite where that has no such number."""
    with np.errstate(over="ignore"):
        return values.astype(np.float32)


def _column(runs: xr.Dataset, dt: np.ndarray) -> dict[str, np.ndarray]:
    """What the maps tell of one step size, each (amplitudes,)."""
    outcome, began = outcomes(runs)
    iterations = np.where(runs.status == NEWTON_FAILED, MAX_ITERATIONS, runs.max_newton_iterations)
    step = np.where(np.isnan(began), -1, np.rint(began / dt))
    return {
        "outcome": outcome,
        "at_step": np.where(runs.status > 0, runs.failed_at_step, step).astype(np.int32),
        "max_energy_error": _single(runs.max_height_error.values),
        "max_newton_iterations": _single(iterations),
        "lyapunov_exponent": _single(runs.lyapunov_exponent.values),
    }


def _sampled(places: np.ndarray, whole: int, points: int) -> np.ndarray:
    """Which of the places on an axis of so many in all are among the at most ``points`` evenly spaced ones."""
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


def _jobs(o) -> dict[str, dict]:
    """One for each scheme and tile."""
    shared = {key: o[key] for key in ("problems", "dt_over_period", "periods", "portraits", "tiles")}
    return {
        f"{scheme}_{tile}": {"scheme": scheme, "tile": tile, **shared}
        for scheme in o["schemes"]
        for tile in range(o["tiles"])
    }


def _too_many(o, c) -> str | None:
    amplitudes = c["atlas"]["amplitudes"]["count"]
    if o["tiles"] > amplitudes:
        return f"tiles: there are more of them, {o['tiles']}, than amplitudes, {amplitudes}."
    if 10 ** o["dt_over_period"]["last"] > o["periods"]:
        return f"dt_over_period: a step is longer than the {o['periods']} periods of the run."
    return None


def _steps(o, c) -> float:
    first, last, count = (o["dt_over_period"][key] for key in ("first", "last", "count"))
    a_run = np.sum(o["periods"] / np.logspace(first, last, min(count, 100))) * max(count / 100, 1)
    return len(o["problems"]) * a_run * c["atlas"]["amplitudes"]["count"] / o["tiles"]


@experiment(
    "stability/atlas",
    "stability/portraits",
    section="atlas",
    model=_Atlas,
    split=_jobs,
    along="scheme,amplitude",
    parts=("stability/tiles", "stability/portraits"),
    reads=lambda o: ["reference/amplitudes"],
    check=_too_many,
    steps=_steps,
    values=lambda o, c: (
        8 * len(o["problems"]) * c["atlas"]["amplitudes"]["count"] * o["dt_over_period"]["count"]
        + 3 * len(o["problems"]) * o["portraits"]["points"] ** 2 * o["portraits"]["samples"]
    ),
    environment=MULTI_OUTPUT_FUSION,
)
def atlas(
    scheme: str,
    problems: Sequence[str],
    dt_over_period: dict[str, float],
    periods: int,
    portraits: dict[str, int],
    tile: int,
    tiles: int,
) -> tuple[xr.Dataset, xr.Dataset]:
    """How the runs of a scheme end, for one of ``tiles`` parts of the amplitudes of ``results/reference/amplitudes``.

    Parameters
    ----------
    dt_over_period
        ``first`` and ``last`` power of ten of Δt/T, with T the period at the amplitude, and the ``count`` of them.
    periods
        Length of the runs in periods.
    portraits
        At how many amplitudes and step sizes, at most, to keep samples (``points``), and how many behind the first
        (``samples``).
    tile
        Which part, from 0 on.

    Returns
    -------
    tuple of xarray.Dataset
        The maps, and the samples.

    Raises
    ------
    ValueError
        If there is no such part.
    """
    if not 0 <= tile < tiles:
        raise ValueError(f"there is no tile {tile} among {tiles}: the first is 0, the last {tiles - 1}.")
    exact = datasets.open("reference/amplitudes").sel(problem=list(problems))
    own = np.array_split(np.arange(exact.sizes["amplitude"]), tiles)[tile]
    sampled = _sampled(own, exact.sizes["amplitude"], portraits["points"])
    exact = exact.isel(amplitude=own)
    parts = np.logspace(dt_over_period["first"], dt_over_period["last"], int(dt_over_period["count"]))
    sampled_parts = _sampled(np.arange(len(parts)), len(parts), portraits["points"])
    spacing = GOLDEN + max(0, round(periods / portraits["samples"] - GOLDEN))
    # a prime, or samples of an orbit that closes after some steps could all fall into one place; and two at least, as
    # a sample at every single step would be another program
    every = np.array([_prime(max(2, round(spacing / part))) for part in parts])
    maps: dict[str, list] = {}
    samples: dict[str, list] = {}
    for name in problems:
        progress(f"stability of {scheme} on {name}")
        problem, of_problem = registry[name], exact.sel(problem=name)
        u0, period, fate = of_problem.u0.values, of_problem.period.values, Fate.of(problem)
        for part, apart, is_sampled in zip(parts, every, sampled_parts, strict=True):
            runs = run(
                problem,
                scheme,
                dt=part * period,
                steps=round(periods / part),
                u0=u0,
                observe=[fate, "lyapunov_exponent", "trajectory", Height(fate.rest)],
                every=int(apart),
                samples=portraits["samples"],
            )
            for variable, column in _column(runs, part * period).items():
                maps.setdefault(variable, []).append(column)
            for variable in ("u", "v", "height") if is_sampled else ():
                samples.setdefault(variable, []).append(_single(runs[variable].values[sampled]))
    dims = ("problem", "amplitude", "dt_over_period")
    attributes = {
        "outcome": OUTCOME_ATTRIBUTES,
        "at_step": {"long_name": "step at which it began, -1 where the run is accurate", "units": "1"},
        "max_energy_error": {
            "long_name": "largest error of the energy over its height above rest, NaN where the run failed",
            "units": "percent",
        },
        "max_newton_iterations": {
            "long_name": f"most Newton iterations in one step, {MAX_ITERATIONS} where they did not converge",
            "units": "1",
        },
        "lyapunov_exponent": {"long_name": "largest Lyapunov exponent of the numerical map", "units": "s-1"},
    } | {name: runs[name].attrs for name in samples}

    def labelled(found, exact, parts, title, *along):
        """The step sizes of each problem, which were found one after the other, behind the amplitudes."""
        shape = (len(problems), len(parts))
        values = {name: np.stack(columns).reshape(*shape, *columns[0].shape) for name, columns in found.items()}
        return (
            xr.Dataset(
                {name: ((*dims, *along), np.moveaxis(v, 1, 2), attributes[name]) for name, v in values.items()},
                coords={
                    **labels.problem_coordinates(problems),
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
            .assign_coords(labels.scheme_coordinates([scheme]))
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
            every=("dt_over_period", every[sampled_parts], {"long_name": "steps between two samples", "units": "1"})
        ),
    )
