"""Observers that hold a run against the exact solution, without storing either trajectory.

They need a reference, so they are made by :func:`against` and not called by name.
"""

from fractions import Fraction

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.observers import Reduction


def _cubic_hermite(s, x0, x1, slope0, slope1):
    """Value at 0 ≤ s ≤ 1 of the cubic with the values x and the slopes dx/ds at both ends."""
    return (
        (1 + 2 * s) * (1 - s) ** 2 * x0 + s * (1 - s) ** 2 * slope0 + s**2 * (3 - 2 * s) * x1 + s**2 * (s - 1) * slope1
    )


def _time_over_rise(rise, rate):
    """Slope of time over displacement in units of the step; at most three, so that no crossing leaves its step.

    Slopes up to three at both ends make the cubic monotonic (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980);
    at fine steps they are near one.
    """
    return jnp.where(3 * rate > rise, rise / jnp.where(rate == 0, 1.0, rate), 3.0)


class TrajectoryError(Reduction):
    """Root mean square and maximum of u − u_exact, relative to the largest |u_exact|.

    Attributes
    ----------
    u, v
        Exact displacement and velocity at the ``steps`` phases of one period, padded to any length.
    steps
        Steps per period.
    lag
        Δt less the exact period over ``steps``: what rounding Δt adds to the time of every step.
    """

    u: jax.Array
    v: jax.Array
    steps: jax.Array
    lag: jax.Array

    variables = {
        "rms_trajectory_error": {"long_name": "root mean square error of the displacement, relative", "units": "1"},
        "max_trajectory_error": {"long_name": "largest error of the displacement, relative", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, effort):
        step, squares, largest = carried
        step = step + 1
        phase = jnp.mod(step, self.steps)
        exact = self.u[phase] + self.v[phase] * (step.astype(float) * self.lag)
        error = jnp.abs(state.u - exact)
        return step, squares + error**2, jnp.maximum(largest, error)

    def result(self, carried, problem, state):
        step, squares, largest = carried
        scale = jnp.max(jnp.abs(self.u))
        return {
            "rms_trajectory_error": jnp.sqrt(squares / step.astype(float)) / scale,
            "max_trajectory_error": largest / scale,
        }


class PeriodError(Reduction):
    """Period elongation and phase error from upward crossings of a level, interpolated between steps.

    Between two steps time is a cubic of the displacement (inverse Hermite interpolation), as exact as a scheme of
    fourth order. The elongation is the mean of all observed periods over the exact one, less one; the phase error is
    how many periods late the last crossing comes. NaN for a motion that does not cross any more, and the elongation
    for one that has crossed once.

    Attributes
    ----------
    level
        The displacement that is crossed.
    crossing
        When the exact solution crosses it first, in periods.
    steps
        Steps per period.
    dt
        Step size.
    """

    level: jax.Array
    crossing: jax.Array
    steps: jax.Array
    dt: jax.Array

    variables = {
        "period_elongation": {"long_name": "relative elongation of the period", "units": "1"},
        "phase_error": {"long_name": "delay of the last upward crossing in periods", "units": "1"},
    }

    def start(self, problem, state):
        return jnp.zeros((), int), state.u, state.v, jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, effort):
        step, u, v, crossings, first, last = carried
        crossed = (u < self.level) & (state.u >= self.level)
        rise = jnp.where(crossed, state.u - u, 1.0)
        slopes = (_time_over_rise(rise, self.dt * rate) for rate in (v, state.v))
        part = _cubic_hermite((self.level - u) / rise, 0.0, 1.0, *slopes)
        at = step.astype(float) + part
        return (
            step + 1,
            state.u,
            state.v,
            crossings + crossed.astype(int),
            jnp.where(crossed & (crossings == 0), at, first),
            jnp.where(crossed, at, last),
        )

    def result(self, carried, problem, state):
        step, *_, crossings, first, last = carried
        between = crossings.astype(float) - 1
        mean_period = jnp.where(crossings > 1, (last - first) / between, self.steps)
        # a motion whose last crossing is long past has come to rest elsewhere, and has no phase
        swings = (crossings > 0) & (step.astype(float) - last < 1.5 * mean_period)
        return {
            "period_elongation": jnp.where(swings & (crossings > 1), mean_period / self.steps - 1, jnp.nan),
            "phase_error": jnp.where(swings, last / self.steps - (self.crossing + between), jnp.nan),
        }


class AmplitudeDecay(Reduction):
    """Relative loss of amplitude per period, from the first to the last maximum after the start.

    NaN with fewer than two.

    Attributes
    ----------
    rest
        The displacement of equilibrium, from which amplitudes are counted.
    dt
        Step size.
    """

    rest: jax.Array
    dt: jax.Array

    variables = {"amplitude_decay": {"long_name": "relative loss of amplitude per period", "units": "1"}}

    def start(self, problem, state):
        return state.u, state.v, jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, effort):
        u, v, maxima, first, last = carried
        turned = (v > 0) & (state.v <= 0)
        part = v / jnp.where(turned, v - state.v, 1.0)
        top = _cubic_hermite(part, u, state.u, self.dt * v, self.dt * state.v) - self.rest
        return (
            state.u,
            state.v,
            maxima + turned.astype(int),
            jnp.where(turned & (maxima == 0), top, first),
            jnp.where(turned, top, last),
        )

    def result(self, carried, problem, state):
        *_, maxima, first, last = carried
        periods = maxima.astype(float) - 1
        return {"amplitude_decay": jnp.where(maxima > 1, 1 - (last / first) ** (1 / periods), jnp.nan)}


def _at_phases(reference: xr.Dataset, steps: int) -> xr.Dataset:
    """The reference at the phases k/steps of one period, k = 0 ... steps − 1."""
    wanted = np.arange(steps) / steps
    at = np.searchsorted(reference.phase.values, wanted - 1e-12)
    if np.any(np.abs(reference.phase.values[at] - wanted) > 1e-12):
        raise ValueError(
            f"the reference of '{reference.problem}' has no phases of {steps} steps per period; "
            f"add {steps} to references.steps_per_period of the configuration."
        )
    return reference.isel(t=at)


def against(reference: xr.Dataset, steps: int, longest: int) -> tuple[float, tuple[Reduction, ...]]:
    """Step size and observers for a run with ``steps`` steps per exact period.

    Parameters
    ----------
    reference
        ``results/reference/PROBLEM.nc``.
    steps
        Steps per period; the reference must hold its phases.
    longest
        Length to which the table of the exact solution is padded, so that one compilation serves all step sizes.

    Raises
    ------
    ValueError
        If the reference does not hold the phases.
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
            jnp.asarray(_first_crossing(reference, level)),
            jnp.asarray(float(steps)),
            jnp.asarray(dt),
        ),
        AmplitudeDecay(jnp.asarray(_rest(reference)), jnp.asarray(dt)),
    )


def uncertainties(reference: xr.Dataset, periods: int) -> dict[str, float]:
    """How well the reference knows the zero of every measure of error, in the units of that measure.

    Trajectory: the displacement's uncertainty over the amplitude. Elongation: the period's, relative. Phase: that of
    all periods, and of the crossing. Amplitude: as the displacement. Energy: how far the energy of the reference,
    rounded to doubles, is from constant, in percent.
    """
    displacement = (reference.u_uncertainty / abs(reference.u).max()).item()
    period = (reference.period_uncertainty / reference.period).item()
    crossing = (reference.u_uncertainty / (abs(reference.v).max() * reference.period)).item()
    energy = 100 * reference.energy_drift.item()
    return {
        "rms_trajectory_error": displacement,
        "max_trajectory_error": displacement,
        "period_elongation": period,
        "phase_error": periods * period + crossing,
        "amplitude_decay": displacement,
        "max_energy_error": energy,
        "energy_drift": energy,
    }


def _rest(reference: xr.Dataset) -> float:
    """The displacement of equilibrium: where the exact motion is fastest."""
    return reference.u.values[np.argmax(np.abs(reference.v.values))]


def _first_crossing(reference: xr.Dataset, level: float) -> float:
    """When the exact solution first crosses ``level`` upwards, in periods, interpolated as in :class:`PeriodError`."""
    u, v, phase = reference.u.values, reference.v.values, reference.phase.values
    i = np.flatnonzero((u[:-1] < level) & (u[1:] >= level))[0]
    rise, width = u[i + 1] - u[i], phase[i + 1] - phase[i]
    slope = rise / (width * reference.period.item())
    return phase[i] + width * _cubic_hermite((level - u[i]) / rise, 0.0, 1.0, slope / v[i], slope / v[i + 1])
