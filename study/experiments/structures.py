"""The schemes on structures: errors against the reference, balance of energy, momentum, effort and failure."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Annotated

import equinox as eqx
import jax
import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study import io
from study.algebra.jit import jit
from study.declaration.checks import no_multiple
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, RisingCounts, Schemes, Structure, StructureLengths, section
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.frequencies import highest_frequency
from study.observer.diagnostics import Evaluations, MomentumErrors, NewtonIterations
from study.observer.energy import EnergyBalance
from study.problem.named import problems as problems_by_name

#: Counts of a run, which are stored per step.
COUNTS = Evaluations.variables
#: Observers of every run; structures with positions also have their momenta observed.
OBSERVERS = ["trajectory", "energy_balance", "newton_iterations", "effort"]
ATTRIBUTES = {
    "displacement_error": {"long_name": "largest error of the displacement over its largest size", "units": "1"},
    "velocity_error": {"long_name": "largest error of the velocity over its largest size", "units": "1"},
    "acceleration_error": {"long_name": "largest error of the acceleration over its largest size", "units": "1"},
    "max_energy_imbalance": EnergyBalance.variables["max_energy_imbalance"],
    # a support changes the linear momentum, so the error of the linear momentum is NaN for structures that are held
    **MomentumErrors.variables,
    "newton_iterations_per_step": {"long_name": "Newton iterations per step", "units": "1"},
    **{
        f"{name}_per_step": {"long_name": f"{attributes['long_name']} per step", "units": "1"}
        for name, attributes in COUNTS.items()
    },
    "max_newton_iterations": NewtonIterations.variables["max_newton_iterations"],
    "status": STATUS_ATTRIBUTES,
    "failed_at_step": FAILED_AT_STEP_ATTRIBUTES,
}


def _size(values: np.ndarray) -> np.ndarray:
    """Largest absolute value over the unknowns, by time."""
    return np.abs(values.reshape(len(values), -1)).max(axis=1)


def _held(definition: Problem, displacements: np.ndarray) -> bool:
    """Whether a support changes the linear momentum: the internal forces at some displacement do not sum to zero."""
    forces = np.asarray(jax.vmap(definition.force)(displacements)).reshape(-1, *np.shape(definition.positions))
    return bool(np.abs(forces.sum(axis=1)).max() > 1e-6 * np.abs(forces).sum(axis=1).max())


def _motion(problem: str, ds: xr.Dataset) -> dict[str, np.ndarray]:
    """Displacement, velocity and the acceleration from the equation of motion, by time.

    The acceleration is left out if the mass is singular or the force has a history.
    """
    t, u, v = (ds[name].values for name in ("t", "u", "v"))
    definition = problems_by_name[problem]
    motion = {"displacement": u, "velocity": v}
    if definition.massless or definition.history is not None:
        return motion
    return motion | {"acceleration": np.asarray(_accelerations(definition, t, u, v))}


@partial(jit, compiler=eqx.filter_jit)
def _accelerations(problem, t, u, v):
    return jax.vmap(lambda *at: acceleration(problem, *at))(t, u, v)


def _measured(problem: str, scheme: str, steps_per_period: int, periods: float, reference: xr.Dataset) -> dict:
    """All variables of one run; errors are NaN if the run failed or the structure lacks the quantity."""
    observe = OBSERVERS + (["momentum_errors"] if problems_by_name[problem].positions is not None else [])
    every = steps_per_period // reference.samples_per_period
    ds = sweep(
        problem,
        scheme,
        dt=reference.period.item() / steps_per_period,
        steps=round(periods * steps_per_period),
        observe=observe,
        every=every,
    )
    exact = _motion(problem, reference.isel(t=slice(ds.sizes["t"] - 1)))
    # a run that failed has NaN, which the maximum keeps
    derived = {
        f"{name}_error": np.max(_size(values - exact[name])) / _size(exact[name]).max()
        for name, values in _motion(problem, ds.isel(t=slice(1, None))).items()
    } | {
        "newton_iterations_per_step": ds.newton_iterations / round(periods * steps_per_period),
        **{f"{name}_per_step": ds[name] / round(periods * steps_per_period) for name in COUNTS},
    }
    return {name: derived.get(name, ds.get(name, np.nan)) for name in ATTRIBUTES}


@section
class _Structures(TypedDict):
    lengths: StructureLengths
    samples_per_period: Count
    rtol: Annotated[float, Ge(1e-14), Le(1e-2)]
    schemes: Schemes
    steps_per_period: RisingCounts


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each structure."""
    shared = {key: options[key] for key in ("schemes", "steps_per_period")}
    return {length["problem"]: {**length, **shared} for length in options["lengths"]}


def _check(options: Options, configuration: Mapping) -> str | None:
    per_period, periods = configuration["structures"]["samples_per_period"], options["periods"]
    samples = periods * per_period
    if round(samples) < 1 or abs(samples - round(samples)) > 1e-9:
        problem = options["problem"]
        return f"lengths: {periods} periods of '{problem}' are not a whole number of samples, {per_period} in each."
    return no_multiple("steps_per_period", options["steps_per_period"], per_period, "samples_per_period")


@experiment(
    "structures",
    model=_Structures,
    split=_jobs,
    along="problem",
    reads=lambda options: [f"reference/{options['problem']}"],
    check=_check,
)
def structures(problem: Structure, schemes: Schemes, steps_per_period: Sequence[int], periods: float) -> xr.Dataset:
    """Measure the errors, balances and effort of every scheme on a structure, by steps per period.

    The error of the displacement is max |u − u_ref| / max |u_ref| over the unknowns and the samples of
    ``reference/PROBLEM``; the errors of velocity and acceleration are defined likewise. The step size is the time scale
    of the structure divided by ``steps_per_period``. Variables have the shape (problem, scheme,
    steps_per_period) or (problem,).

    Raises
    ------
    ValueError
        If a number of steps per period is not a multiple of the samples of the reference in a period.
    FileNotFoundError
        If the reference of the structure has not been made.
    """
    reference = io.open_dataset(f"reference/{problem}")
    for steps in steps_per_period:
        if steps % reference.samples_per_period:
            raise ValueError(
                f"steps_per_period {steps} is not a multiple of the {reference.samples_per_period} samples that the "
                f"reference of '{problem}' has in a period."
            )
    dims = ("problem", "scheme", "steps_per_period")
    shape = (1, len(schemes), len(steps_per_period))
    values = {name: np.empty(shape) for name in ATTRIBUTES}
    definition = problems_by_name[problem]
    held = definition.positions is not None and _held(definition, reference.u.values)
    for s, scheme in enumerate(schemes):
        progress(f"{scheme} on {problem}")
        for k, steps in enumerate(steps_per_period):
            for name, value in _measured(problem, scheme, steps, periods, reference).items():
                values[name][0, s, k] = value
    if held:
        values["max_linear_momentum_error"][:] = np.nan
    whole = {"status": np.int32, "failed_at_step": np.int64}
    of_reference = {
        "displacement_uncertainty": (reference.u_uncertainty.max() / _size(reference.u.values).max()).item(),
        "unknowns": np.size(definition.u0),
        "period": reference.period.item(),
        "periods": periods,
        "highest_frequency": highest_frequency(definition, [definition.u0, *reference.u.values]),
    }
    long_names = {
        "displacement_uncertainty": ("uncertainty of the reference in units of displacement_error", "1"),
        "unknowns": ("number of unknowns", "1"),
        "period": ("time by which steps are counted", "s"),
        "periods": ("length of the runs in units of period", "1"),
        "highest_frequency": ("highest circular frequency of small motions along the reference", "s-1"),
    }
    return xr.Dataset(
        {name: (dims, value.astype(whole.get(name, float)), ATTRIBUTES[name]) for name, value in values.items()}
        | {
            name: ("problem", [value], {"long_name": long_names[name][0], "units": long_names[name][1]})
            for name, value in of_reference.items()
        },
        coords={
            **coordinates.problem_coordinates([problem]),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
        },
        attrs={"title": "The schemes on structures: errors, balances and failures"},
    )
