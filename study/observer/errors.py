"""Observers that hold a run against the exact solution, without storing either trajectory.

They need a reference, so they are made by :func:`against` and not called by name.
"""

import jax
import jax.numpy as jnp
from jax import lax

from study.equilibrium.balance import acceleration
from study.observer.base import Reduction
from study.problem.definition import Problem

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
