"""Sensitivity to the initial displacement: the distance of two runs that start next to each other."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.declaration.checks import less_than_a_step
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Schemes, Size, Spring, Tolerance
from study.experiments import coordinates
from study.marching.run import run
from study.problem.named import problems as problems_by_name


def _check(options: Options, configuration: Mapping) -> str | None:
    return less_than_a_step("duration", options["duration"], options["dt"])


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    return 2 * len(options["schemes"]) * options["duration"] / options["dt"]


def _numbers_held(options: Options, configuration: Mapping) -> float:
    return 2 * _number_of_steps(options, configuration)


@experiment("sensitivity", check=_check, steps=_number_of_steps, values=_numbers_held)
def sensitivity(problem: Spring, schemes: Schemes, dt: Size, duration: Size, perturbation: Tolerance) -> xr.Dataset:
    """Compute the distance over time of two runs that start next to each other, for every scheme.

    The distance |Δu| has the shape (scheme, t). The initial displacements differ by ``perturbation``; ``dt`` and
    ``duration`` are in seconds.
    """
    progress(f"sensitivity of {problem}")
    u0 = float(problems_by_name[problem].u0) + np.array([0.0, perturbation])
    pairs = [
        run(problem, scheme, dt=dt, steps=round(duration / dt), u0=u0, on_failure="ignore").u for scheme in schemes
    ]
    separation = np.stack([np.abs(u.values[1] - u.values[0]) for u in pairs])
    return xr.Dataset(
        {
            "separation": (
                ("scheme", "t"),
                separation,
                {"long_name": "distance of the displacements of two runs", "units": "1"},
            ),
            "perturbation": ((), perturbation, {"long_name": "initial distance", "units": "1"}),
        },
        coords={"t": pairs[0].t, **coordinates.scheme_coordinates(schemes)},
        attrs={"title": f"Sensitivity of the schemes to the initial displacement: {problems_by_name[problem].title}"},
    )
