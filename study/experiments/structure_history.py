"""Histories of structures: motion and energy error over time, or the energies of the stiff springs of the chain."""

from collections.abc import Mapping
from functools import partial

import jax
import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Name, Schemes, Size, Structure, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.mechanics.definition import Problem
from study.observer.base import Observer
from study.observer.motion import Quantity
from study.problem.chains import oscillatory_energy
from study.problem.named import problems as problems_by_name
from study.problem.named import time_scales


def _sum_of_energies(u, v):
    return sum(oscillatory_energy(spring, u, v) for spring in range(3))


def _observers(problem: str, definition: Problem) -> list[str | Observer]:
    if problem == "fpu_chain":
        at_start = float(_sum_of_energies(definition.u0, definition.v0))
        change = Quantity(
            lambda u, v: _sum_of_energies(u, v) / at_start - 1,
            "max_sum_change",
            "largest relative change of the sum of the oscillatory energies over all steps",
            reduce="peak",
        )
        along_time = [
            Quantity(
                partial(oscillatory_energy, spring),
                f"oscillatory_energy_{spring + 1}",
                f"oscillatory energy of stiff spring {spring + 1}",
            )
            for spring in range(3)
        ]
        return [*along_time, change]
    from_rest = float(definition.energy(definition.u0, definition.v0)) == 0
    return ["trajectory"] if from_rest else ["trajectory", "energy_error"]


@section
class _History(TypedDict):
    problem: Structure
    schemes: Schemes
    steps_per_period: Count
    periods: Size
    every: Count


def _check(options: Options, configuration: Mapping) -> str | None:
    steps = round(options["periods"] * options["steps_per_period"])
    if steps < options["every"] or steps % options["every"]:
        return f"every, {options['every']}, does not divide the number of steps, {steps}."
    return None


@experiment(
    "structure_history",
    model=dict[Name, _History],
    split=dict,
    reads=lambda options: [f"reference/{options['problem']}"],
    check=_check,
)
def structure_history(
    problem: Structure, schemes: Schemes, steps_per_period: int, periods: float, every: int
) -> xr.Dataset:
    """Record the motion of a structure over time with every scheme at one step size, and its reference.

    The histories of ``fpu_chain`` are the energies of its stiff springs. The histories of other structures are
    displacement and velocity, and the energy error unless the initial energy is zero. Histories have the shape
    (scheme, t, ...), and histories of the reference have the shape (t_reference, ...).

    Parameters
    ----------
    steps_per_period, periods
        Steps in the time scale of the structure (``study.problem.named.time_scales``), and number of time scales.
    every
        Number of steps from one sample to the next.

    Raises
    ------
    FileNotFoundError
        If the reference of the structure has not been made.
    """
    progress(f"histories of {problem}")
    definition = problems_by_name[problem]
    observe = _observers(problem, definition)
    dt, steps = time_scales[problem] / steps_per_period, round(periods * steps_per_period)
    runs = [sweep(problem, scheme, dt=dt, steps=steps, observe=observe, every=every) for scheme in schemes]
    dataset = xr.concat(runs, "scheme", combine_attrs="override").assign_coords(coordinates.scheme_coordinates(schemes))
    reference = io.open_dataset(f"reference/{problem}")
    exact = {"u": reference.u.values, "v": reference.v.values}
    for quantity in observe:
        if isinstance(quantity, Quantity) and quantity.reduce is None:
            exact[quantity.name] = np.asarray(jax.vmap(quantity.function)(exact["u"], exact["v"]))
    for name, values in exact.items():
        if name in dataset:
            dims = ("t_reference", "component")[: values.ndim]
            attributes = {**dataset[name].attrs, "long_name": f"{dataset[name].long_name} of the reference"}
            dataset[f"reference_{name}"] = (dims, values, attributes)
    dataset = dataset.assign_coords(
        t_reference=("t_reference", reference.t.values, {"long_name": "elapsed time of the reference", "units": "s"})
    )
    dataset["step_size"] = ((), np.float64(dt), {"long_name": "step size", "units": "s"})
    dataset["steps_per_period"] = (
        (),
        steps_per_period,
        {"long_name": "steps in the time scale of the motion", "units": "1"},
    )
    dataset.attrs = {
        "title": f"Histories of the {definition.title} at one step size",
        "problem": problem,
        "problem_title": definition.title,
    }
    return dataset
