"""Why Runge-Kutta's error falls to 1.0 % at T/20 and rises to 8.3 % at T/25: the drift over many step sizes."""

from typing import Annotated

import numpy as np
import xarray as xr
from annotated_types import Ge, Le
from typing_extensions import TypedDict

from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES
from study.marching.run import run
from study.observer.crossings import crosses_upwards
from study.pipeline import labels
from study.pipeline.command import progress
from study.pipeline.experiment import experiment
from study.pipeline.options import Count, SchemeName, Spring, section
from study.problem.named import printed_periods


def _steps_per_oscillation(u: np.ndarray, oscillations: int) -> float:
    """Mean number of steps between the last ``oscillations`` upward crossings of zero, interpolated linearly.

    NaN where the motion does not cross zero often enough.
    """
    before = np.flatnonzero(crosses_upwards(u[:-1], u[1:], 0))[-oscillations - 1 :]
    if len(before) < oscillations + 1:
        return np.nan
    crossings = before + u[before] / (u[before] - u[before + 1])
    return (crossings[-1] - crossings[0]) / oscillations


@section
class _Parts(TypedDict):
    first: Annotated[float, Ge(1), Le(1e6)]
    last: Annotated[float, Ge(1), Le(1e6)]
    step: Annotated[float, Ge(1e-6), Le(1e6)]


def _in_order(o, c) -> str | None:
    first, last = (o["steps_per_period"][key] for key in ("first", "last"))
    if first >= last:
        return f"steps_per_period: first, {first}, must be less than last, {last}."
    return None


def _steps(o, c) -> float:
    parts = o["steps_per_period"]
    return ((parts["last"] - parts["first"]) / parts["step"] + 1) * parts["last"] * o["periods"]


@experiment("energy_drift", check=_in_order, steps=_steps, values=lambda o, c: 3 * _steps(o, c))
def energy_drift(
    problem: Spring,
    scheme: SchemeName,
    steps_per_period: _Parts,
    periods: Count,
    oscillations: Count,
) -> xr.Dataset:
    """Signed energy error after ``periods`` periods, and how many steps an oscillation then takes.

    Parameters
    ----------
    steps_per_period
        ``first``, ``last`` and ``step`` of the printed period's parts.
    oscillations
        How many of the last oscillations the count is averaged over.
    """
    progress(f"energy drift of {scheme} on {problem}")
    first, last, step = (steps_per_period[key] for key in ("first", "last", "step"))
    parts = np.round(np.arange(first, last + step / 2, step), 10)
    steps = np.round(parts * periods).astype(int)
    # one ensemble over all step sizes, long enough for the finest; each is read off at its own end
    lanes = run(
        problem,
        scheme,
        dt=printed_periods[problem] / parts,
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
                {"long_name": f"signed relative error of the total energy after {periods} periods", "units": "percent"},
            ),
            "steps_per_oscillation": (
                along,
                count,
                {"long_name": f"steps that one of the last {oscillations} oscillations takes", "units": "1"},
            ),
            "status": (along, lanes.status.values, STATUS_ATTRIBUTES),
            "failed_at_step": (along, lanes.failed_at_step.values, FAILED_AT_STEP_ATTRIBUTES),
        },
        coords=labels.steps_per_period_coordinate(parts),
        attrs={
            "title": f"Energy drift of {scheme} on the {problem} problem over step sizes",
            "problem": problem,
            "scheme": scheme,
        },
    )
