"""Regular or chaotic? How far two runs drift apart that start next to each other."""

import numpy as np
import xarray as xr

from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Schemes, Size, Spring, Tolerance
from study.problem.named import problems


def _length(o, c) -> str | None:
    if o["duration"] < o["dt"]:
        return f"a duration of {o['duration']} is less than one step of {o['dt']}."
    return None


@experiment(
    "sensitivity",
    check=_length,
    steps=lambda o, c: 2 * len(o["schemes"]) * o["duration"] / o["dt"],
    values=lambda o, c: 4 * len(o["schemes"]) * o["duration"] / o["dt"],
)
def sensitivity(problem: Spring, schemes: Schemes, dt: Size, duration: Size, perturbation: Tolerance) -> xr.Dataset:
    """Distance |Δu| of two runs whose initial displacements differ by ``perturbation``, along time."""
    progress(f"sensitivity of {problem}")
    u0 = float(problems[problem].u0) + np.array([0.0, perturbation])
    pairs = [run(problem, scheme, dt=dt, steps=round(duration / dt), u0=u0).u for scheme in schemes]
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
        coords={"t": pairs[0].t, **labels.scheme_coordinates(schemes)},
        attrs={"title": f"Sensitivity of the schemes to the initial displacement: {problems[problem].title}"},
    )
