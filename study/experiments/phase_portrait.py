"""Figures 1 to 4 of Xie (1996): what every scheme makes of an orbit."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study.marching.run import run
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Schemes, Size, Spring, section
from study.problem.named import problems


@section
class _Portrait(TypedDict):
    schemes: Schemes
    dt: Size
    duration: Size


def _length(o, c) -> str | None:
    if o["duration"] < o["dt"]:
        return f"{o['problem']}: a duration of {o['duration']} is less than one step of {o['dt']}."
    return None


@experiment(
    "phase_portrait",
    model=dict[Spring, _Portrait],
    split=lambda o: {problem: {"problem": problem, **portrait} for problem, portrait in o.items()},
    check=_length,
    steps=lambda o, c: len(o["schemes"]) * o["duration"] / o["dt"],
    values=lambda o, c: 4 * len(o["schemes"]) * o["duration"] / o["dt"],
)
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
