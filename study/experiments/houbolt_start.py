"""Which start did the paper give Houbolt's method? The printed errors under every candidate."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import main, progress
from study.problem.named import printed_periods
from study.scheme.houbolt import Houbolt, starts


def houbolt_start(problems: Sequence[str], steps_per_period: Sequence[int], periods: int) -> xr.Dataset:
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


if __name__ == "__main__":
    main(houbolt_start)
