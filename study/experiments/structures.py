"""The schemes on structures: error of the displacement, balance of energies, and failure."""

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study import io
from study.declaration.checks import no_multiple
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, RisingCounts, Schemes, Structure, StructureLengths, section
from study.experiments import coordinates
from study.marching.result import STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.observer.energy import EnergyBalance
from study.problem.named import problems as problems_by_name

ATTRIBUTES = {
    "sampled_displacement_error": {
        "long_name": "error of the displacement at the samples over the largest displacement",
        "units": "1",
    },
    "max_energy_imbalance": EnergyBalance.variables["max_energy_imbalance"],
    "status": STATUS_ATTRIBUTES,
}


def _size(values: np.ndarray) -> np.ndarray:
    """Largest absolute value over the unknowns, by time."""
    return np.abs(values.reshape(len(values), -1)).max(axis=1)


def _measured(problem: str, scheme: str, steps_per_period: int, periods: float, reference: xr.Dataset) -> dict:
    """All variables of one run; errors are NaN if the run failed."""
    ds = sweep(
        problem,
        scheme,
        dt=reference.period.item() / steps_per_period,
        steps=round(periods * steps_per_period),
        observe=["trajectory", "energy_balance"],
        every=steps_per_period // reference.samples_per_period,
    )
    exact = reference.u.values[: ds.sizes["t"] - 1]
    # a run that failed has NaN, which the maximum keeps
    error = np.max(_size(ds.u.values[1:] - exact)) / _size(exact).max()
    return {
        "sampled_displacement_error": error,
        **{name: ds[name].item() for name in ("max_energy_imbalance", "status")},
    }


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
    """Measure the error of the displacement and the balance of energies of every scheme, by steps per period.

    The error of the displacement is max |u − u_ref| / max |u_ref| over the unknowns and the samples of
    ``reference/PROBLEM``. The step size is the time scale of the structure divided by ``steps_per_period``. Variables
    have the shape (problem, scheme, steps_per_period) or (problem,).

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
    for s, scheme in enumerate(schemes):
        progress(f"{scheme} on {problem}")
        for k, steps in enumerate(steps_per_period):
            for name, value in _measured(problem, scheme, steps, periods, reference).items():
                values[name][0, s, k] = value
    by_problem = {
        "displacement_uncertainty": (reference.u_uncertainty.max() / _size(reference.u.values).max()).item(),
        "unknowns": np.size(problems_by_name[problem].u0),
        "periods": periods,
    }
    long_names = {
        "displacement_uncertainty": ("uncertainty of the reference in units of sampled_displacement_error", "1"),
        "unknowns": ("number of unknowns", "1"),
        "periods": ("length of the runs in units of period", "1"),
    }
    return xr.Dataset(
        {
            name: (dims, value.astype(np.int32 if name == "status" else float), ATTRIBUTES[name])
            for name, value in values.items()
        }
        | {
            name: ("problem", [value], {"long_name": long_names[name][0], "units": long_names[name][1]})
            for name, value in by_problem.items()
        },
        coords={
            **coordinates.problem_coordinates([problem]),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.steps_per_period_coordinate(steps_per_period),
        },
        attrs={"title": "The schemes on structures: errors, balances and failures"},
    )
