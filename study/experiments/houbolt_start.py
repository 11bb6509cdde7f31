"""Energy error of Houbolt's method for each way to start it; Xie (1996) does not state which way he used."""

import numpy as np
import xarray as xr

from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, Counts, Springs
from study.experiments import coordinates
from study.marching.run import sweep
from study.problem.named import approximate_periods
from study.scheme.houbolt import Houbolt, starts


@experiment("houbolt_start")
def houbolt_start(problems: Springs, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """Compute the largest energy error of Houbolt's method for every way to start it.

    The error is max |E − E₀|/|E₀| over ``periods`` printed periods, of shape
    (problem, steps_per_period, start). ``study.scheme.houbolt.starts`` lists the ways to start.
    """
    error = np.empty((len(problems), len(steps_per_period), len(starts)))
    for p, problem in enumerate(problems):
        progress(f"starts of Houbolt's method on {problem}")
        for s, start in enumerate(starts):
            for k, steps in enumerate(steps_per_period):
                dt = approximate_periods[problem] / steps
                ds = sweep(
                    problem,
                    Houbolt(start_by=start),
                    dt=dt,
                    steps=steps * periods,
                    observe=["max_energy_error"],
                )
                error[p, k, s] = ds.max_energy_error
    return xr.Dataset(
        {"max_energy_error": (("problem", "steps_per_period", "start"), error, coordinates.energy_attributes(periods))},
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "start": ("start", list(starts), {"long_name": "how the displacements before t = 0 are found"}),
        },
        attrs={"title": "Largest energy error of Houbolt's method by start, problem and step size"},
    )
