"""Largest energy error of the schemes at printed and at exact periods, as in Tables 1 and 2 of Xie (1996)."""

import numpy as np
import xarray as xr

from study.declaration.experiment import experiment, progress, references
from study.declaration.options import Count, Counts, Schemes, Springs
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep


@experiment("energy_error", reads=references)
def energy_error(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """Compute the largest energy error of every scheme on every problem at every step size.

    The error is max |E − E₀|/|E₀| over ``periods`` periods, eq. (17) of Xie (1996). The step size is T/N,
    with N = ``steps_per_period`` and T the printed or the exact period. ``max_energy_error`` has the shape
    (period_used, problem, steps_per_period, scheme).

    Raises
    ------
    FileNotFoundError
        If the reference of a problem, which holds its exact period, has not been made.
    """
    period_used = ["printed", "exact"]
    shape = (len(period_used), len(problems), len(steps_per_period), len(schemes))
    error, period = np.full(shape, np.nan), np.empty(shape[:2])
    status, failed_at_step = np.zeros(shape, np.int32), np.full(shape, -1)
    for p, problem in enumerate(problems):
        progress(f"energy error on {problem}")
        known = coordinates.periods(problem)
        for s, scheme in enumerate(schemes):
            for i, used in enumerate(period_used):
                period[i, p] = known[used]
                for k, steps in enumerate(steps_per_period):
                    ds = sweep(
                        problem,
                        scheme,
                        dt=known[used] / steps,
                        steps=steps * periods,
                        observe=["max_energy_error"],
                    )
                    at = i, p, k, s
                    error[at], status[at], failed_at_step[at] = ds.max_energy_error, ds.status, ds.failed_at_step
    dims = ("period_used", "problem", "steps_per_period", "scheme")
    return xr.Dataset(
        {
            "max_energy_error": (dims, error, coordinates.energy_attributes(periods)),
            "status": (dims, status, STATUS_ATTRIBUTES),
            "failed_at_step": (dims, failed_at_step, FAILED_AT_STEP_ATTRIBUTES),
            "period": (dims[:2], period, {"long_name": "period that gives the step size", "units": "s"}),
        },
        coords={
            "period_used": (
                "period_used",
                period_used,
                {"long_name": "period whose fraction is the step size: the rounded one of the paper or the exact one"},
            ),
            **coordinates.problem_coordinates(problems),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            **coordinates.scheme_coordinates(schemes),
        },
        attrs={"title": "Largest energy error by problem, step size and scheme (Tables 1 and 2 of the paper)"},
    )
