"""Phase portraits of the numerical map: where its iterates lie from many initial states, at growing step sizes."""

import numpy as np
import xarray as xr

from study.marching.result import STATUS_ATTRIBUTES
from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Numbers, RecordedSteps, Schemes, Sizes, Spring
from study.problem.named import problems


def _iterates(o, c) -> int:
    return len(o["schemes"]) * len(o["dt"]) * o["u0"]["count"] * o["steps"]


@experiment("stability/numerical_map", steps=_iterates, values=lambda o, c: 3 * _iterates(o, c))
def numerical_map(problem: Spring, schemes: Schemes, dt: Sizes, u0: Numbers, steps: RecordedSteps) -> xr.Dataset:
    """Displacement and velocity after every step, from rest at many displacements.

    Parameters
    ----------
    dt
        Step sizes.
    u0
        ``first``, ``last`` and ``count`` of the initial displacements.
    steps
        Iterates of each.
    """
    starts = np.linspace(u0["first"], u0["last"], int(u0["count"]))
    of_lanes = np.tile(starts, len(dt)), np.repeat(dt, len(starts))
    runs = []
    for scheme in schemes:
        progress(f"numerical map of {scheme} on {problem}")
        runs.append(run(problem, scheme, u0=of_lanes[0], dt=of_lanes[1], steps=steps))
    shape = (len(schemes), len(dt), len(starts))
    dims = ("scheme", "dt", "u0")

    def iterates(name, units):
        with np.errstate(over="ignore"):  # a run on its way out of all numbers leaves those of single precision first
            values = np.stack([one[name].values for one in runs]).astype(np.float32)
        return (*dims, "iterate"), values.reshape(*shape, -1), {**runs[0][name].attrs, "units": units}

    return xr.Dataset(
        {
            "u": iterates("u", "1"),
            "v": iterates("v", "s-1"),
            "status": (dims, np.stack([one.status.values for one in runs]).reshape(shape), STATUS_ATTRIBUTES),
        },
        coords={
            **labels.scheme_coordinates(schemes),
            "dt": ("dt", list(dt), {"long_name": "step size", "units": "s"}),
            "u0": ("u0", starts, {"long_name": "initial displacement", "units": "1"}),
            "iterate": ("iterate", np.arange(steps + 1), {"long_name": "steps taken", "units": "1"}),
        },
        attrs={"title": f"Iterates of the schemes on the {problems[problem].title}", "problem": problem},
    )
