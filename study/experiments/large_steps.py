"""Energy error and failure of the schemes from small steps to steps as long as the period."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from study.declaration.checks import step_beyond_run
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Schemes, Sizes, Springs
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.problem.named import approximate_periods


def _check(options: Options, configuration: Mapping) -> str | None:
    return step_beyond_run(max(options["step_size_over_period"]), options["periods"])


@experiment("large_steps", check=_check)
def large_steps(problems: Springs, schemes: Schemes, step_size_over_period: Sizes, periods: Count) -> xr.Dataset:
    """Compute energy error and failure of every scheme from small steps to steps as long as the period.

    The largest error is max |E − E₀|/|E₀| over ``periods`` printed periods, eq. (17) of Xie (1996). The
    drift is (E − E₀)/|E₀| at the end. The late gain is the largest (E − E₀)/|E₀| in the second half, so that an
    overshoot of the first steps does not count. All variables have the shape
    (problem, scheme, step_size_over_period).
    """
    dims = ("problem", "scheme", "step_size_over_period")
    shape = (len(problems), len(schemes), len(step_size_over_period))
    error, drift, late = (np.empty(shape) for _ in range(3))
    status, failed_at_step = np.zeros(shape, np.int32), np.empty(shape, int)
    for p, problem in enumerate(problems):
        progress(f"large steps on {problem}")
        for s, scheme in enumerate(schemes):
            for r, part in enumerate(step_size_over_period):
                ds = sweep(
                    problem,
                    scheme,
                    dt=approximate_periods[problem] * part,
                    steps=round(periods / part),
                    observe="energy_error",
                )
                at, along = (p, s, r), ds.energy_error.values  # NaN after a failure, from the failing step on
                error[at], drift[at], late[at] = np.abs(along).max(), along[-1], along[len(along) // 2 :].max()
                status[at], failed_at_step[at] = ds.status, ds.failed_at_step
    return xr.Dataset(
        {
            "max_energy_error": (dims, error, coordinates.energy_attributes(periods)),
            "energy_drift": (
                dims,
                drift,
                {"long_name": "signed relative error of the total energy at the end", "units": "1"},
            ),
            "late_energy_gain": (
                dims,
                late,
                {"long_name": "largest gain of the total energy in the second half of the run", "units": "1"},
            ),
            "status": (dims, status, STATUS_ATTRIBUTES),
            "failed_at_step": (dims, failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            "step_size_over_period": (
                "step_size_over_period",
                list(step_size_over_period),
                {"long_name": "step size over the printed period", "units": "1"},
            ),
        },
        attrs={"title": "Energy error and failure of the schemes at small and at large steps"},
    )
