"""Comparison of runs with the exact solution: step sizes, observers, and the uncertainty of the reference."""

from fractions import Fraction

import jax.numpy as jnp
import numpy as np
import xarray as xr
from scipy.interpolate import CubicHermiteSpline

from study.io import flags
from study.observer.crossings import crosses_upwards
from study.observer.errors import AmplitudeDecay, PeriodError, TrajectoryError

#: Measures of error.
MEASURES = (
    "rms_displacement_error",
    "displacement_error",
    "period_elongation",
    "phase_error",
    "amplitude_decay",
    "max_energy_error",
    "energy_drift",
)

#: Largest error that is flagged as possibly an error of the reference, as a multiple of the reference's uncertainty.
FLAGGED_WITHIN = 10


def _at_phases(reference: xr.Dataset, steps: int) -> xr.Dataset:
    """The reference at the phases k/steps of one period, for k = 0, ..., steps − 1."""
    phases = np.arange(steps) / steps
    at = np.searchsorted(reference.phase.values, phases - 1e-12)
    if np.any(np.abs(reference.phase.values[at] - phases) > 1e-12):
        raise ValueError(
            f"the reference of '{reference.problem}' has no phases of {steps} steps per period; "
            f"add {steps} to references.steps_per_period of the configuration."
        )
    return reference.isel(t=at)


def against(
    reference: xr.Dataset, steps: int, longest: int
) -> tuple[float, tuple[TrajectoryError, PeriodError, AmplitudeDecay]]:
    """Step size of a run with ``steps`` steps per exact period, and observers that compare the run with the reference.

    Parameters
    ----------
    reference
        Dataset ``reference/PROBLEM``.
    steps
        Steps per exact period; the reference must hold these phases.
    longest
        Length to which the table of the exact solution is padded, so that one compilation serves all step sizes.

    Returns
    -------
    dt, observers
        Step size, and the observers of trajectory, period and amplitude.

    Raises
    ------
    ValueError
        If the reference does not hold these phases, or its motion never crosses the mean of its extremes upwards.
    """
    once = _at_phases(reference, steps)
    dt = reference.period.item() / steps
    exact_period = Fraction(reference.period.item()) + Fraction(reference.period_remainder.item())
    lag = float(Fraction(dt) - exact_period / steps)
    padding = (0, longest - steps)
    level = (reference.u.max().item() + reference.u.min().item()) / 2
    return dt, (
        TrajectoryError(
            jnp.asarray(np.pad(once.u.values, padding)),
            jnp.asarray(np.pad(once.v.values, padding)),
            jnp.asarray(steps),
            jnp.asarray(lag),
        ),
        PeriodError(
            jnp.asarray(level),
            jnp.asarray(first_crossing(reference, level)),
            jnp.asarray(float(steps)),
            jnp.asarray(dt),
        ),
        AmplitudeDecay(jnp.asarray(_rest(reference)), jnp.asarray(dt)),
    )


def uncertainties(reference: xr.Dataset, periods: int) -> dict[str, float]:
    """Uncertainty of the reference for every measure of error, in the units of that measure.

    - both errors of the trajectory: uncertainty of the displacement, relative to its maximum;
    - elongation of the period: relative uncertainty of the period;
    - phase: uncertainty of the sum of all periods plus the uncertainty of the time of a crossing, in periods;
    - decay of the amplitude: uncertainty of the displacement, relative to the amplitude, per period;
    - both errors of the energy: variation of the energy along the reference, whose values are rounded to doubles.
    """
    displacement = (reference.u_uncertainty / abs(reference.u).max()).item()
    period = (reference.period_uncertainty / reference.period).item()
    crossing = (reference.u_uncertainty / (abs(reference.v).max() * reference.period)).item()
    amplitude = (reference.u_uncertainty / (reference.u.max() - _rest(reference))).item()
    energy = reference.energy_drift.item()
    known = (displacement, displacement, period, periods * period + crossing, amplitude / periods, energy, energy)
    return dict(zip(MEASURES, known, strict=True))


def flagged(error: np.ndarray, uncertainty, dims: tuple[str, ...]) -> tuple:
    """Variable that flags each error: above ten times the uncertainty, not above, or not measured (NaN)."""
    within = np.where(np.isnan(error), 2, np.abs(error) <= FLAGGED_WITHIN * uncertainty)
    question = f"whether the error is within {FLAGGED_WITHIN} times the uncertainty of the reference"
    return dims, within.astype(np.int32), flags(question, ("above", "within", "not_measured"), np.int32)


def _rest(reference: xr.Dataset) -> float:
    """Displacement of equilibrium, where the exact velocity is largest, by parabolas through three points."""
    i = int(np.argmax(np.abs(reference.v.values)))
    near = slice(max(i - 1, 0), i + 2)
    t, u, v = reference.t.values[near], reference.u.values[near], reference.v.values[near]
    curvature, slope, _ = np.polyfit(t - t[1], v, 2)
    return float(np.polyval(np.polyfit(t - t[1], u, 2), -slope / (2 * curvature)))


def first_crossing(reference: xr.Dataset, level: float) -> float:
    """Time in periods at which the exact solution first crosses ``level`` upwards, interpolated by Hermite's cubic.

    Raises
    ------
    ValueError
        If the solution does not cross ``level`` upwards.
    """
    u, v, phase = reference.u.values, reference.v.values, reference.phase.values
    crossed = np.flatnonzero(crosses_upwards(u[:-1], u[1:], level))
    if not crossed.size:
        raise ValueError(f"the exact motion of '{reference.problem}' does not cross {level:g} upwards.")
    ends = slice(crossed[0], crossed[0] + 2)
    between = CubicHermiteSpline(phase[ends], u[ends] - level, v[ends] * reference.period.item())
    return float(between.roots(extrapolate=False)[0])
