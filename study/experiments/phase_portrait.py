"""Phase portraits and energy errors of the schemes at one step size, as in Figures 1 to 4 of Xie (1996)."""

from collections.abc import Mapping
from functools import partial

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study.declaration.checks import less_than_a_step
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Schemes, Size, Spring, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.base import Observer
from study.observer.outcome import Height, OutcomeObserver
from study.problem.named import problems as problems_by_name


@section
class _Portrait(TypedDict):
    schemes: Schemes
    dt: Size
    duration: Size


def _check(options: Options, configuration: Mapping) -> str | None:
    return less_than_a_step("duration", options["duration"], options["dt"])


@experiment(
    "phase_portrait",
    model=dict[Spring, _Portrait],
    split=lambda options: {problem: {"problem": problem, **portrait} for problem, portrait in options.items()},
    check=_check,
)
def phase_portrait(problem: Spring, schemes: Schemes, dt: float, duration: float) -> xr.Dataset:
    """Compute displacement, velocity and energy of every scheme over time at one step size.

    ``dt`` and ``duration`` are in seconds. The energy error is (E − E₀)/|E₀|. ``height`` is the energy above the energy
    at rest, relative to its initial value. All histories have the shape (scheme, t).
    """
    progress(f"phase portraits of {problem}")
    steps = round(duration / dt)
    observe: list[str | Observer] = ["trajectory", "energy_error", Height(OutcomeObserver.of(problem).rest)]
    # without a bound of the displacement, so that the dataset has the step at which the numbers overflow, as in 1996
    marched = partial(sweep, problem, dt=dt, steps=steps, observe=observe, bound=np.inf)
    runs = [marched(scheme=scheme) for scheme in schemes]
    dataset = xr.concat(runs, "scheme", combine_attrs="override").assign_coords(coordinates.scheme_coordinates(schemes))
    dataset["step_size"] = ((), np.float64(dt), {"long_name": "step size", "units": "s"})
    dataset.attrs = {
        "title": f"Phase portraits and energy error of the {problems_by_name[problem].title} at one step size",
        "problem": problem,
        "problem_title": problems_by_name[problem].title,
    }
    return dataset
