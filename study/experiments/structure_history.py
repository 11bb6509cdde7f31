"""Histories of structures: the motion, the energy and, of the chain, the energies of its stiff springs."""

from collections.abc import Sequence
from functools import partial

import jax
import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import datasets
from study.marching.run import run
from study.observer.base import Observer
from study.observer.motion import Quantity
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, Name, Schemes, Size, Structure, section
from study.problem.chains import oscillatory_energy
from study.problem.definition import Problem
from study.problem.named import problems, time_scales


def _observers(problem: str, definition: Problem) -> list[str | Observer]:
    if problem == "fpu_chain":
        return [
            Quantity(
                partial(oscillatory_energy, spring),
                f"oscillatory_energy_{spring + 1}",
                f"oscillatory energy of stiff spring {spring + 1}",
            )
            for spring in range(3)
        ]
    from_rest = float(definition.energy(definition.u0, definition.v0)) == 0
    return ["trajectory"] if from_rest else ["trajectory", "energy_error"]


@section
class _History(TypedDict):
    problem: Structure
    schemes: Schemes
    steps_per_period: Count
    periods: Size
    every: Count


def _length(o, c) -> str | None:
    steps = round(o["periods"] * o["steps_per_period"])
    if steps < o["every"] or steps % o["every"]:
        return f"every, {o['every']}, does not divide the number of steps, {steps}."
    return None


@experiment(
    "structure_history",
    model=dict[Name, _History],
    split=dict,
    reads=lambda o: [f"reference/{o['problem']}"],
    check=_length,
    steps=lambda o, c: len(o["schemes"]) * o["periods"] * o["steps_per_period"],
    values=lambda o, c: 600 * len(o["schemes"]) * o["periods"] * o["steps_per_period"] / o["every"],
)
def structure_history(
    problem: str, schemes: Sequence[str], steps_per_period: int, periods: float, every: int
) -> xr.Dataset:
    """What is worth seeing of every scheme at one step size, and of the reference where it has the time."""
    progress(f"histories of {problem}")
    definition = problems[problem]
    observe = _observers(problem, definition)
    dt, steps = time_scales[problem] / steps_per_period, round(periods * steps_per_period)
    runs = [run(problem, scheme, dt=dt, steps=steps, observe=observe, every=every) for scheme in schemes]
    dataset = xr.concat(runs, "scheme", combine_attrs="override").assign_coords(labels.scheme_coordinates(schemes))
    reference = datasets.open(f"reference/{problem}")
    exact = {"u": reference.u.values, "v": reference.v.values}
    for quantity in observe:
        if isinstance(quantity, Quantity):
            exact[quantity.name] = np.asarray(jax.vmap(quantity.function)(exact["u"], exact["v"]))
    for name, values in exact.items():
        if name in dataset:
            dims = ("t_reference", "component")[: values.ndim]
            attributes = {**dataset[name].attrs, "long_name": f"{dataset[name].long_name} of the reference"}
            dataset[f"reference_{name}"] = (dims, values, attributes)
    dataset = dataset.assign_coords(
        t_reference=("t_reference", reference.t.values, {"long_name": "elapsed time of the reference", "units": "s"})
    )
    dataset["dt"] = ((), np.float64(dt), {"long_name": "step size", "units": "s"})
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
