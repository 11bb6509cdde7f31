"""Which start did the paper give Houbolt's method? The printed errors under every candidate."""

import numpy as np
import xarray as xr

from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, Counts, Springs
from study.problem.named import printed_periods
from study.scheme.houbolt import Houbolt, starts


@experiment(
    "houbolt_start",
    steps=lambda o, c: len(starts) * len(o["problems"]) * sum(o["steps_per_period"]) * o["periods"],
)
def houbolt_start(problems: Springs, steps_per_period: Counts, periods: Count) -> xr.Dataset:
    """Largest energy error of Houbolt's method over ``periods`` printed periods, by how it is started."""
    error = np.empty((len(problems), len(steps_per_period), len(starts)))
    for p, problem in enumerate(problems):
        progress(f"starts of Houbolt's method on {problem}")
        for s, start in enumerate(starts):
            for k, steps in enumerate(steps_per_period):
                dt = printed_periods[problem] / steps
                ds = run(problem, Houbolt(start_by=start), dt=dt, steps=steps * periods, observe=["max_energy_error"])
                error[p, k, s] = ds.max_energy_error
    attributes = {"long_name": f"largest relative error of the total energy over {periods} periods", "units": "percent"}
    return xr.Dataset(
        {"max_energy_error": (("problem", "steps_per_period", "start"), error, attributes)},
        coords={
            **labels.problem_coordinates(problems),
            **labels.steps_per_period_coordinate(steps_per_period),
            "start": ("start", list(starts), {"long_name": "how the displacements before t = 0 are found"}),
        },
        attrs={"title": "Largest energy error of Houbolt's method by start, problem and step size"},
    )
