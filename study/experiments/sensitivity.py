"""Sensitivity to the initial displacement: the distance of runs that start next to each other."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.declaration.checks import less_than_a_step
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Schemes, Size, Spring, Tolerance
from study.experiments import coordinates
from study.marching.run import sweep
from study.problem.named import problems as problems_by_name

#: Differences of the initial displacements of the runs from the initial displacement of the problem, in multiples of
#: ``perturbation``.
STARTS = (0, *(way * k for k in range(1, 21) for way in (1, -1)))

#: Distance at which two displacements count as separated.
APART = 0.1


def _check(options: Options, configuration: Mapping) -> str | None:
    return less_than_a_step("duration", options["duration"], options["dt"])


@experiment("sensitivity", check=_check)
def sensitivity(problem: Spring, schemes: Schemes, dt: Size, duration: Size, perturbation: Tolerance) -> xr.Dataset:
    """Compute the distance over time of runs that start next to each other, for every scheme.

    The initial displacements of the first two runs differ by ``perturbation``. Their distance |Δu| has the shape
    (scheme, t). In chaotic motion, the step at which a run parts from the first run, and the number of changes of sign,
    vary from run to run. Both are given for many runs, (scheme, start). ``dt`` and ``duration`` are in seconds.
    """
    progress(f"sensitivity of {problem}")
    u0 = float(problems_by_name[problem].u0) + perturbation * np.array(STARTS)
    runs = [sweep(problem, scheme, dt=dt, steps=round(duration / dt), u0=u0).u for scheme in schemes]
    u = np.stack([history.values for history in runs])
    distance = np.abs(u - u[:, :1])
    parted = distance > APART
    return xr.Dataset(
        {
            "separation": (
                ("scheme", "t"),
                distance[:, 1],
                {"long_name": "distance of the displacements of two runs", "units": "1"},
            ),
            "parted_at_step": (
                ("scheme", "start"),
                np.where(parted.any(axis=-1), parted.argmax(axis=-1), -1),
                {"long_name": f"step at which the distance from the first run exceeds {APART:g}, or -1", "units": "1"},
            ),
            "changes_of_sign": (
                ("scheme", "start"),
                (u[..., 1:] * u[..., :-1] < 0).sum(axis=-1),
                {"long_name": "changes of sign of the displacement", "units": "1"},
            ),
            "perturbation": ((), perturbation, {"long_name": "initial distance", "units": "1"}),
        },
        coords={
            "t": runs[0].t,
            "start": ("start", list(STARTS), {"long_name": "initial distance in perturbations", "units": "1"}),
            **coordinates.scheme_coordinates(schemes),
        },
        attrs={"title": f"Sensitivity of the schemes to the initial displacement: {problems_by_name[problem].title}"},
    )
