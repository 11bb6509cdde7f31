"""Drift of the energy over many step sizes.

The drift explains why the printed error of the Runge-Kutta method falls to 1.0 % at T/20 and rises to 8.3 % at T/25.
"""

from collections.abc import Mapping
from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import IN_ORDER, Count, SchemeName, Spring, section
from study.experiments import coordinates
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import sweep
from study.observer.crossings import crosses_upwards
from study.problem.named import approximate_periods


def _steps_per_oscillation(u: np.ndarray, oscillations: int) -> float:
    """Mean number of steps per oscillation, over the last ``oscillations`` oscillations of u with shape (steps + 1,).

    An oscillation ends where u, interpolated linearly, crosses zero upwards. The result is NaN if u has fewer
    oscillations.
    """
    before = np.flatnonzero(crosses_upwards(u[:-1], u[1:], 0))[-oscillations - 1 :]
    if len(before) < oscillations + 1:
        return np.nan
    crossings = before + u[before] / (u[before] - u[before + 1])
    return (crossings[-1] - crossings[0]) / oscillations


@section
class _StepsPerPeriod(TypedDict):
    first: Annotated[float, Ge(1), Le(1e6)]
    last: Annotated[float, Ge(1), Le(1e6)]
    step: Annotated[float, Ge(1e-6), Le(1e6)]


def _check(options: Options, configuration: Mapping) -> str | None:
    if options["oscillations"] >= options["periods"]:
        return f"oscillations must be less than periods, {options['periods']}, not {options['oscillations']}."
    return None


@experiment("energy_drift", check=_check)
def energy_drift(
    problem: Spring,
    scheme: SchemeName,
    steps_per_period: Annotated[_StepsPerPeriod, IN_ORDER],
    periods: Count,
    oscillations: Count,
) -> xr.Dataset:
    """Compute the signed energy error at the end of a run and the steps per oscillation, over step sizes.

    The energy error is (E − E₀)/|E₀| after ``periods`` periods. Both variables have the shape (steps_per_period,).

    Parameters
    ----------
    steps_per_period
        ``first``, ``last`` and ``step`` of N in Δt = T/N, with T the printed period.
    oscillations
        Number of oscillations at the end of a run over which the steps per oscillation are averaged.
    """
    progress(f"energy drift of {scheme} on {problem}")
    first, last, step = (steps_per_period[key] for key in ("first", "last", "step"))
    parts = np.round(np.arange(first, last + step / 2, step), 10)
    steps = np.round(parts * periods).astype(int)
    # all runs take as many steps as the run with the finest step; each run is evaluated at the end of its periods
    lanes = sweep(
        problem,
        scheme,
        dt=approximate_periods[problem] / parts,
        steps=steps.max().item(),
        observe=["trajectory", "energy_error"],
    )
    drift = lanes.energy_error.values[np.arange(len(parts)), steps]
    count = [_steps_per_oscillation(u[: n + 1], oscillations) for u, n in zip(lanes.u.values, steps, strict=True)]
    along = "steps_per_period"
    return xr.Dataset(
        {
            "energy_drift": (
                along,
                drift,
                {"long_name": f"signed relative error of the total energy after {periods} periods", "units": "1"},
            ),
            "steps_per_oscillation": (
                along,
                count,
                {"long_name": f"mean number of steps of the last {oscillations} oscillations", "units": "1"},
            ),
            "status": (along, lanes.status.values, STATUS_ATTRIBUTES),
            "failed_at_step": (along, lanes.failed_at_step.values, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords={
            **coordinates.steps_per_period_coordinate(parts),
            "periods": ((), periods, {"long_name": "length of the runs in periods", "units": "1"}),
        },
        attrs={
            "title": f"Energy drift of {scheme} on the {problem} problem over step sizes",
            "problem": problem,
            "scheme": scheme,
        },
    )
