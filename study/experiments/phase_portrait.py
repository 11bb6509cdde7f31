"""Figures 1 to 4 of Xie (1996): what every scheme makes of an orbit."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import main, progress
from study.problem.named import problems


def phase_portrait(problem: str, schemes: Sequence[str], dt: float, duration: float) -> xr.Dataset:
    """Displacement, velocity and energy error of every scheme at the step size ``dt`` up to ``duration``."""
    progress(f"phase portraits of {problem}")
    steps = round(duration / dt)
    runs = [run(problem, scheme, dt=dt, steps=steps, observe=["trajectory", "energy_error"]) for scheme in schemes]
    dataset = xr.concat(runs, "scheme", combine_attrs="override").assign_coords(labels.scheme_coordinates(schemes))
    dataset["dt"] = ((), np.float64(dt), {"long_name": "step size", "units": "s"})
    dataset.attrs = {
        "title": f"Phase portraits and energy error of the {problems[problem].title} at one step size",
        "problem": problem,
        "problem_title": problems[problem].title,
    }
    return dataset


if __name__ == "__main__":
    main(phase_portrait)
