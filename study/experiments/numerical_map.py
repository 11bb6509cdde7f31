"""Phase portraits of the numerical map, which takes each state to the state one step later."""

import numpy as np
import xarray as xr

from study.declaration.experiment import experiment, progress
from study.declaration.options import Numbers, RecordedSteps, Schemes, Sizes, Spring
from study.experiments import coordinates
from study.marching.result import STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name


@experiment("stability/numerical_map")
def numerical_map(problem: Spring, schemes: Schemes, dt: Sizes, u0: Numbers, steps: RecordedSteps) -> xr.Dataset:
    """Compute the iterates of the schemes from rest at many initial displacements, at several step sizes.

    Parameters
    ----------
    dt
        Step sizes in seconds.
    u0
        ``first``, ``last`` and ``count`` of the initial displacements.
    steps
        Number of iterates after each initial state.

    Returns
    -------
    xarray.Dataset
        ``u`` and ``v`` have the shape (scheme, dt, u0, iterate), ``status`` has the shape (scheme, dt, u0).
    """
    starts = np.linspace(u0["first"], u0["last"], int(u0["count"]))
    of_lanes = np.tile(starts, len(dt)), np.repeat(dt, len(starts))
    runs = []
    for scheme in schemes:
        progress(f"numerical map of {scheme} on {problem}")
        runs.append(sweep(problem, scheme, u0=of_lanes[0], dt=of_lanes[1], steps=steps))
    shape = (len(schemes), len(dt), len(starts))
    dims = ("scheme", "step_size", "u0")

    def iterates(name, units):
        with np.errstate(over="ignore"):  # values of a diverging run may exceed the range of single precision
            values = np.stack([one[name].values for one in runs]).astype(np.float32)
        return (*dims, "iterate"), values.reshape(*shape, -1), {**runs[0][name].attrs, "units": units}

    return xr.Dataset(
        {
            "u": iterates("u", "1"),
            "v": iterates("v", "s-1"),
            "status": (dims, np.stack([one.status.values for one in runs]).reshape(shape), STATUS_ATTRIBUTES),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            "step_size": ("step_size", list(dt), {"long_name": "step size", "units": "s"}),
            "u0": ("u0", starts, {"long_name": "initial displacement", "units": "1"}),
            "iterate": ("iterate", np.arange(steps + 1), {"long_name": "steps taken", "units": "1"}),
        },
        attrs={"title": f"Iterates of the schemes on the {problems_by_name[problem].title}", "problem": problem},
    )
