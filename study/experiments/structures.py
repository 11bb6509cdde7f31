"""What becomes of the schemes on structures: error, balance of energy, momentum and effort, or how they fail."""

from collections.abc import Sequence
from typing import Annotated

import jax
import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study import datasets
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import run
from study.observer.effort import NewtonIterations
from study.observer.energy import EnergyBalance
from study.observer.momentum import MomentumErrors
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, Counts, Schemes, StructureLengths, section
from study.problem.definition import Problem
from study.problem.named import problems

#: What a run is asked for, and the variables that only some problems have.
OBSERVERS = ["trajectory", "energy_balance", "newton_iterations"]
ATTRIBUTES = {
    "displacement_error": {"long_name": "largest error of the displacement over its largest size", "units": "1"},
    "velocity_error": {"long_name": "largest error of the velocity over its largest size", "units": "1"},
    "max_energy_imbalance": EnergyBalance.variables["max_energy_imbalance"],
    # of what is held the support takes linear momentum, and its change is no error
    **MomentumErrors.variables,
    "iterations_per_step": {"long_name": "Newton iterations per step", "units": "1"},
    "max_newton_iterations": NewtonIterations.variables["max_newton_iterations"],
    "status": STATUS_ATTRIBUTES,
    "failed_at_step": FAILED_AT_STEP_ATTRIBUTES,
}


def _norm(values: np.ndarray) -> np.ndarray:
    """Euclidean norm over the unknowns, by time."""
    return np.linalg.norm(values.reshape(len(values), -1), axis=1)


def _held(definition: Problem, displacements: np.ndarray) -> bool:
    """Whether a support takes linear momentum: internal forces that do not add up to nothing."""
    forces = np.asarray(jax.vmap(definition.force)(displacements)).reshape(-1, *np.shape(definition.positions))
    return bool(np.abs(forces.sum(axis=1)).max() > 1e-6 * np.abs(forces).sum(axis=1).max())


def _measured(problem: str, scheme: str, steps_per_period: int, periods: float, reference: xr.Dataset) -> dict:
    """Every variable of one run."""
    observe = OBSERVERS + (["momentum_errors"] if problems[problem].positions is not None else [])
    every = steps_per_period // reference.samples_per_period
    ds = run(
        problem,
        scheme,
        dt=reference.period.item() / steps_per_period,
        steps=round(periods * steps_per_period),
        observe=observe,
        every=every,
    )
    exact = reference.isel(t=slice(ds.sizes["t"] - 1))
    # NaN of a run that failed stays
    error = {
        name: np.max(_norm(ds[name].values[1:] - exact[name].values)) / _norm(exact[name].values).max()
        for name in ("u", "v")
    }
    derived = {
        "displacement_error": error["u"],
        "velocity_error": error["v"],
        "iterations_per_step": ds.newton_iterations / round(periods * steps_per_period),
    }
    return {name: derived.get(name, ds.get(name, np.nan)) for name in ATTRIBUTES}


@section
class _Structures(TypedDict):
    lengths: StructureLengths
    samples_per_period: Count
    rtol: Annotated[float, Ge(1e-14), Le(1e-2)]
    schemes: Schemes
    steps_per_period: Counts


def _samples(o, c) -> str | None:
    samples = c["structures"]["samples_per_period"]
    for steps in o["steps_per_period"]:
        if steps % samples:
            return f"steps_per_period: {steps} is no multiple of samples_per_period, {samples}."
    if round(o["periods"] * samples) < 1 or abs(o["periods"] * samples - round(o["periods"] * samples)) > 1e-9:
        return f"lengths: {o['periods']} periods of '{o['problem']}' are no whole number of samples, {samples} in each."
    return None


@experiment(
    "structures",
    model=_Structures,
    split=lambda o: {
        one["problem"]: {**one, "schemes": o["schemes"], "steps_per_period": o["steps_per_period"]}
        for one in o["lengths"]
    },
    along="problem",
    reads=lambda o: [f"reference/{o['problem']}"],
    check=_samples,
    values=lambda o, c: 600 * o["periods"] * c["structures"]["samples_per_period"],
    steps=lambda o, c: o["periods"] * len(o["schemes"]) * sum(o["steps_per_period"]),
)
def structures(problem: str, schemes: Sequence[str], steps_per_period: Sequence[int], periods: float) -> xr.Dataset:
    """Every scheme on one structure, by steps per period, against the reference of ``reference/PROBLEM``.

    Raises
    ------
    ValueError
        If the reference has no sample at whole steps.
    """
    reference = datasets.open(f"reference/{problem}")
    for steps in steps_per_period:
        if steps % reference.samples_per_period:
            raise ValueError(
                f"steps_per_period {steps} is no multiple of the {reference.samples_per_period} samples that the "
                f"reference of '{problem}' has in a period."
            )
    dims = ("problem", "scheme", "steps_per_period")
    shape = (1, len(schemes), len(steps_per_period))
    values = {name: np.empty(shape) for name in ATTRIBUTES}
    held = problems[problem].positions is not None and _held(problems[problem], reference.u.values)
    for s, scheme in enumerate(schemes):
        progress(f"{scheme} on {problem}")
        for k, steps in enumerate(steps_per_period):
            for name, value in _measured(problem, scheme, steps, periods, reference).items():
                values[name][0, s, k] = value
    if held:
        values["max_linear_momentum_error"][:] = np.nan
    whole = {"status": np.int32, "failed_at_step": np.int64}
    of_reference = {
        "displacement_uncertainty": (reference.u_uncertainty.max() / _norm(reference.u.values).max()).item(),
        "unknowns": np.size(problems[problem].u0),
        "period": reference.period.item(),
        "periods": periods,
    }
    long_names = {
        "displacement_uncertainty": ("uncertainty of the reference in units of displacement_error", "1"),
        "unknowns": ("number of unknowns", "1"),
        "period": ("time by which steps are counted", "s"),
        "periods": ("length of the runs in these times", "1"),
    }
    return xr.Dataset(
        {name: (dims, value.astype(whole.get(name, float)), ATTRIBUTES[name]) for name, value in values.items()}
        | {
            name: ("problem", [value], {"long_name": long_names[name][0], "units": long_names[name][1]})
            for name, value in of_reference.items()
        },
        coords={
            **labels.problem_coordinates([problem]),
            **labels.scheme_coordinates(schemes),
            **labels.steps_per_period_coordinate(steps_per_period),
        },
        attrs={"title": "The schemes on structures: errors, balances and failures"},
    )
