"""Observers that hold a run against the exact solution, without storing either trajectory.

They need a reference, so they are made by :func:`against` and not called by name.
"""

from fractions import Fraction

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax import lax
from scipy.interpolate import CubicHermiteSpline

from study.equilibrium import acceleration
from study.observers import Reduction
from study.problem import Problem

#: The measures of error of the study, those of the energy in percent.
MEASURES = (
    "rms_trajectory_error",
    "max_trajectory_error",
    "period_elongation",
    "phase_error",
    "amplitude_decay",
    "max_energy_error",
    "energy_drift",
)
#: An error this many times the reference's uncertainty or less says as much of the reference as of the scheme.
FLAGGED_WITHIN = 10
#: Halvings that find a root between two steps to round-off.
HALVINGS = 53


def _between(start, end, dt, of_v: bool = False):
    """Coefficients in 0 ≤ s ≤ 1, lowest first, of the quintic with u, u̇ and ü of two steps, or of its velocity."""
    (u0, v0, a0), (u1, v1, a1) = start, end
    v0, v1, a0, a1 = dt * v0, dt * v1, dt**2 * a0, dt**2 * a1
    rise = u1 - u0 - v0 - a0 / 2
    slope, curvature = v1 - v0 - a0, a1 - a0
    quintic = (
        u0,
        v0,
        a0 / 2,
        10 * rise - 4 * slope + curvature / 2,
        -15 * rise + 7 * slope - curvature,
        6 * rise - 3 * slope + curvature / 2,
    )
    return tuple(k * c for k, c in enumerate(quintic))[1:] if of_v else quintic


def _value(coefficients, s):
    result = jnp.zeros_like(s)
    for coefficient in reversed(coefficients):
        result = result * s + coefficient
    return result


def _root(coefficients):
    """Where in 0 ≤ s ≤ 1 the polynomial changes its sign, as its ends do, by bisection: no slope can mislead it."""
    sign = jnp.sign(_value(coefficients, jnp.ones_like(coefficients[0])))

    def halve(_, bracket):
        low, high = bracket
        middle = (low + high) / 2
        beyond = sign * _value(coefficients, middle) > 0
        return jnp.where(beyond, low, middle), jnp.where(beyond, middle, high)

    low, high = lax.fori_loop(0, HALVINGS, halve, (jnp.zeros_like(sign), jnp.ones_like(sign)))
    return (low + high) / 2


def _kinematics(problem: Problem, state):
    """Displacement, velocity and the acceleration that the free motion has there."""
    return state.u, state.v, acceleration(problem, 0.0, state.u, state.v)


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

    def update(self, carried, problem, state, t, effort):
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

    Between two steps the displacement is the quintic that has their displacements, velocities and accelerations, as
    exact as a scheme of fifth order. The elongation is the mean of all observed periods over the exact one, less one;
    the phase error is how many periods late the last crossing comes. NaN for a motion that does not cross any more,
    and the elongation for one that has crossed once.

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
        return jnp.zeros((), int), _kinematics(problem, state), jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        step, before, crossings, first, last = carried
        now = _kinematics(problem, state)
        crossed = (before[0] < self.level) & (now[0] >= self.level)

        def part():
            displacement, *rest = _between(before, now, self.dt)
            return _root((displacement - self.level, *rest))

        at = step.astype(float) + lax.cond(crossed, part, lambda: jnp.zeros(()))
        return (
            step + 1,
            now,
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

    The maxima are those of the quintics of :class:`PeriodError`. NaN with fewer than two.

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
        return _kinematics(problem, state), jnp.zeros((), int), jnp.zeros(()), jnp.zeros(())

    def update(self, carried, problem, state, t, effort):
        before, maxima, first, last = carried
        now = _kinematics(problem, state)
        turned = (before[1] > 0) & (now[1] <= 0)

        def amplitude():
            at = _root(_between(before, now, self.dt, of_v=True))
            return _value(_between(before, now, self.dt), at) - self.rest

        top = lax.cond(turned, amplitude, lambda: jnp.zeros(()))
        return (
            now,
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
            jnp.asarray(first_crossing(reference, level)),
            jnp.asarray(float(steps)),
            jnp.asarray(dt),
        ),
        AmplitudeDecay(jnp.asarray(_rest(reference)), jnp.asarray(dt)),
    )


def uncertainties(reference: xr.Dataset, periods: int) -> dict[str, float]:
    """How well the reference knows the zero of every measure of error, in the units of that measure.

    Trajectory: the displacement's uncertainty over the amplitude. Elongation: the period's, relative. Phase: that of
    all periods, and of the crossing. Amplitude: the displacement's over the amplitude and the periods. Energy: how far
    the energy of the reference, rounded to doubles, is from constant, in percent.
    """
    displacement = (reference.u_uncertainty / abs(reference.u).max()).item()
    period = (reference.period_uncertainty / reference.period).item()
    crossing = (reference.u_uncertainty / (abs(reference.v).max() * reference.period)).item()
    amplitude = (reference.u_uncertainty / (reference.u.max() - _rest(reference))).item()
    energy = 100 * reference.energy_drift.item()
    known = (displacement, displacement, period, periods * period + crossing, amplitude / periods, energy, energy)
    return dict(zip(MEASURES, known, strict=True))


def flagged(error: np.ndarray, uncertainty, dims: tuple[str, ...]) -> tuple:
    """Variable that tells where an error is within ten times the reference's uncertainty, or was not measured."""
    within = np.where(np.isnan(error), 2, np.abs(error) <= FLAGGED_WITHIN * uncertainty)
    attributes = {
        "long_name": f"whether the error is within {FLAGGED_WITHIN} times the uncertainty of the reference",
        "flag_values": np.arange(3, dtype=np.int32),
        "flag_meanings": "above within not_measured",
    }
    return dims, within.astype(np.int32), attributes


def _rest(reference: xr.Dataset) -> float:
    """The displacement of equilibrium: where the exact motion is fastest, at the vertex of a parabola through it."""
    i = int(np.argmax(np.abs(reference.v.values)))
    near = slice(max(i - 1, 0), i + 2)
    t, u, v = reference.t.values[near], reference.u.values[near], reference.v.values[near]
    curvature, slope, _ = np.polyfit(t - t[1], v, 2)
    return float(np.polyval(np.polyfit(t - t[1], u, 2), -slope / (2 * curvature)))


def first_crossing(reference: xr.Dataset, level: float) -> float:
    """When the exact solution first crosses ``level`` upwards, in periods, interpolated by a cubic.

    Raises
    ------
    ValueError
        If it does not.
    """
    u, v, phase = reference.u.values, reference.v.values, reference.phase.values
    crossed = np.flatnonzero((u[:-1] < level) & (u[1:] >= level))
    if not crossed.size:
        raise ValueError(f"the exact motion of '{reference.problem}' does not cross {level:g}.")
    ends = slice(crossed[0], crossed[0] + 2)
    between = CubicHermiteSpline(phase[ends], u[ends] - level, v[ends] * reference.period.item())
    return float(between.roots(extrapolate=False)[0])
