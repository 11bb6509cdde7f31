"""Errors of energy and period at all amplitudes, by the step size times the highest frequency of the motion."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.analysis.step_bound import orbit
from study.declaration.experiment import experiment, progress
from study.declaration.options import Count, PowersOfTen, Schemes, section
from study.experiments import coordinates
from study.marching.run import sweep
from study.observer.crossings import Oscillations
from study.observer.outcome import OutcomeObserver
from study.problem.named import problems as problems_by_name


@section
class _StepRule(TypedDict):
    schemes: Schemes
    omega_steps: PowersOfTen
    periods: Count


def _values(exponents: Mapping[str, float]) -> np.ndarray:
    return np.logspace(exponents["first"], exponents["last"], int(exponents["count"]))


@experiment("stability/step_rule", section="step_rule", model=_StepRule, reads=lambda options: ["reference/amplitudes"])
def step_rule(schemes: Schemes, omega_steps: dict[str, float], periods: int) -> xr.Dataset:
    """Measure the errors of energy and period by ω Δt, with ω the highest frequency of the tangent along each motion.

    The problems and amplitudes come from ``results/reference/amplitudes``.

    Parameters
    ----------
    omega_steps
        ``count`` values of ω Δt, from 10 to the power ``first`` to 10 to the power ``last``.
    periods
        Length of the runs in exact periods.

    Returns
    -------
    xarray.Dataset
        ``max_energy_error`` and ``period_error`` of shape (scheme, problem, amplitude, omega_step).
        ``described_up_to``, the largest ω Δt at which the bound of the energy by its modified energy holds
        (:func:`study.step_bound`), of shape (problem, amplitude).

    Raises
    ------
    FileNotFoundError
        If ``results/reference/amplitudes.nc`` has not been made.
    """
    exact, values = io.open_dataset("reference/amplitudes"), _values(omega_steps)
    problems = exact.problem.values.tolist()
    shape = (len(schemes), len(problems), exact.sizes["amplitude"], len(values))
    energy, elongation, described = np.full(shape, np.nan), np.full(shape, np.nan), np.empty(shape[1:3])
    for p, problem in enumerate(problems):
        definition, motions = problems_by_name[problem], exact.sel(problem=problem)
        well = OutcomeObserver.of(definition)
        initial = np.array([definition.energy(value, 0.0) for value in motions.u0.values])
        over_height = np.abs(initial) / (initial - well.rest)
        described[p] = [orbit(replace(definition, u0=value)).described_up_to for value in motions.u0.values.tolist()]
        step = values / motions.highest_frequency.values[:, None]
        u0, period = (
            np.broadcast_to(variable.values[:, None], step.shape) for variable in (motions.u0, motions.period)
        )
        for s, scheme in enumerate(schemes):
            progress(f"highest frequency and step of {scheme} on {problem}")
            runs = sweep(
                definition,
                scheme,
                dt=step.ravel(),
                steps=np.ceil(periods * period / step).astype(int).ravel(),
                u0=u0.ravel(),
                observe=["max_energy_error", Oscillations(well.rest_at)],
            )
            energy[s, p] = runs.max_energy_error.values.reshape(step.shape) * over_height[:, None]
            elongation[s, p] = np.abs(runs.mean_period.values.reshape(step.shape) / period - 1)
    dims = ("scheme", "problem", "amplitude", "omega_step")
    failed = "NaN where the run failed"
    return xr.Dataset(
        {
            "max_energy_error": (
                dims,
                energy,
                {"long_name": f"largest error of the energy over its height above rest, {failed}", "units": "1"},
            ),
            "period_error": (
                dims,
                elongation,
                {"long_name": f"relative error of the mean period, {failed} or has no period", "units": "1"},
            ),
            "described_up_to": (
                ("problem", "amplitude"),
                described,
                {"long_name": "largest ω Δt at which the bound of the energy holds", "units": "1"},
            ),
        },
        coords={
            **coordinates.scheme_coordinates(schemes),
            **coordinates.problem_coordinates(problems),
            "amplitude": exact.amplitude,
            "period": exact.period,
            "highest_frequency": exact.highest_frequency,
            "periods": ((), periods, {"long_name": "length of the runs in periods", "units": "1"}),
            "omega_step": (
                "omega_step",
                values,
                {"long_name": "step size times the highest circular frequency of the motion", "units": "1"},
            ),
        },
        attrs={"title": f"Errors of {periods} periods by the step times the highest frequency of the motion"},
    )
