"""Errors of a run against the exact solution, observed without storing the trajectory of the run.

These observers need values of the exact solution, so they have no names. :func:`study.analysis.comparison.against`
makes them from a reference dataset.
"""

from functools import partial

import jax
import jax.numpy as jnp
from jax import lax

from study.algebra.elementwise import quintic, value
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.observer.base import Reduction
from study.observer.crossings import crosses_upwards

#: Number of bisections that locate a root within a step to round-off.
HALVINGS = 53


def _root(coefficients):
    """Root in 0 ≤ s ≤ 1 of a polynomial of opposite signs at 0 and 1, by bisection, which cannot leave the step."""
    sign = jnp.sign(value(coefficients, jnp.ones_like(coefficients[0])))

    def halve(_, bracket):
        low, high = bracket
        middle = (low + high) / 2
        beyond = sign * value(coefficients, middle) > 0
        return jnp.where(beyond, low, middle), jnp.where(beyond, middle, high)

    low, high = lax.fori_loop(0, HALVINGS, halve, (jnp.zeros_like(sign), jnp.ones_like(sign)))
    return (low + high) / 2


def _chosen(condition, value, other):
    """The step ``value`` in the lanes where ``condition`` holds, and the step ``other`` in the other lanes.

    The root within the chosen step is found after the run: most steps of an ensemble have a root in some lane, so that
    a search during the run would take time in almost every step. The choice is made one step later; otherwise XLA would
    compute the force of the step once more for every choice.
    """
    return jax.tree.map(partial(jnp.where, condition), value, other)


def _quintic(problem: Problem, before, after, dt, derivative: bool = False):
    """Coefficients of the quintic through u, u̇ and the acceleration of the free motion at both ends of a step.

    With ``derivative``, the coefficients of its derivative.
    """
    start, end = ((u, v, acceleration(problem, 0.0, u, v)) for u, v in (before, after))
    return quintic(start, end, dt, derivative)


class TrajectoryError(Reduction):
    """Root mean square and maximum of |u − u_exact| over all steps, relative to the largest |u_exact|.

    Attributes
    ----------
    u, v
        Exact displacement and velocity at ``steps`` equally spaced times of a period, padded at the end to any length.
    steps
        Steps per exact period.
    lag
        Δt − T/``steps`` with the exact period T: the rounding error of Δt, by which each step shifts the time.
    """

    u: jax.Array
    v: jax.Array
    steps: jax.Array
    lag: jax.Array

    needs_equal_steps = True
    variables = {
        "rms_displacement_error": {"long_name": "root mean square error of the displacement, relative", "units": "1"},
        "displacement_error": {"long_name": "largest error of the displacement, relative", "units": "1"},
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
            "rms_displacement_error": jnp.sqrt(squares / step.astype(float)) / scale,
            "displacement_error": largest / scale,
        }


class PeriodError(Reduction):
    """Period elongation and phase error from upward crossings of a level, interpolated within steps.

    Within a step, the displacement is interpolated by the quintic with displacement, velocity and acceleration at both
    ends, which is exact enough for schemes up to fifth order. The elongation is T̄/T − 1, with T̄ the mean time between
    crossings and T the exact period. The phase error is the delay of the last crossing in exact periods. Both are NaN
    if the motion never crosses the level or has stopped crossing it. The elongation is also NaN with fewer than two
    crossings.

    Attributes
    ----------
    level
        Displacement that is crossed.
    crossing
        Time of the first crossing of the exact solution, in exact periods.
    steps
        Steps per exact period.
    dt
        Step size.
    """

    level: jax.Array
    crossing: jax.Array
    steps: jax.Array
    dt: jax.Array

    needs_equal_steps = True
    variables = {
        "period_elongation": {"long_name": "relative elongation of the period", "units": "1"},
        "phase_error": {"long_name": "delay of the last upward crossing in periods", "units": "1"},
    }

    def start(self, problem, state):
        start = state.u, state.v
        step = jnp.zeros(()), start, start
        return jnp.zeros((), int), start, start, jnp.zeros((), int), step, step

    def _with_last_crossing(self, carried):
        step, before, after, crossings, first, last = carried
        crossed = crosses_upwards(before[0], after[0], self.level)
        step_ends = step.astype(float) - 1, before, after
        first, last = _chosen(crossed & (crossings == 0), step_ends, first), _chosen(crossed, step_ends, last)
        return step, before, after, crossings + crossed.astype(int), first, last

    def update(self, carried, problem, state, t, effort):
        step, _, after, *others = self._with_last_crossing(carried)
        return step + 1, after, (state.u, state.v), *others

    def result(self, carried, problem, state):
        step, _, _, crossings, *ends = self._with_last_crossing(carried)
        first, last = (self._crossing(problem, *end) for end in ends)
        between = crossings.astype(float) - 1
        mean_period = jnp.where(crossings > 1, (last - first) / between, self.steps)
        # a motion without a crossing for one and a half mean periods has settled elsewhere and has no phase
        swings = (crossings > 0) & (step.astype(float) - last < 1.5 * mean_period)
        return {
            "period_elongation": jnp.where(swings & (crossings > 1), mean_period / self.steps - 1, jnp.nan),
            "phase_error": jnp.where(swings, last / self.steps - (self.crossing + between), jnp.nan),
        }

    def _crossing(self, problem, step, before, after):
        displacement, *coefficients = _quintic(problem, before, after, self.dt)
        return step + _root((displacement - self.level, *coefficients))


class AmplitudeDecay(Reduction):
    """Relative loss of amplitude per oscillation over the n maxima after the start, NaN with fewer than two maxima.

    The loss is :math:`1 - (A_n/A_1)^{1/(n - 1)}`, the geometric mean per oscillation of the numerical motion. Maxima
    are found on the same quintics as the crossings of :class:`PeriodError`.

    Attributes
    ----------
    rest
        Displacement at equilibrium, from which the amplitudes A are measured.
    dt
        Step size.
    """

    rest: jax.Array
    dt: jax.Array

    needs_equal_steps = True
    variables = {
        "amplitude_decay": {
            "long_name": "relative loss of amplitude, geometric mean per oscillation of the numerical motion",
            "units": "1",
        }
    }

    def start(self, problem, state):
        start = state.u, state.v
        return start, start, jnp.zeros((), int), (start, start), (start, start)

    def _with_last_maximum(self, carried):
        before, after, maxima, first, last = carried
        turned = (before[1] > 0) & (after[1] <= 0)
        step_ends = before, after
        first, last = _chosen(turned & (maxima == 0), step_ends, first), _chosen(turned, step_ends, last)
        return before, after, maxima + turned.astype(int), first, last

    def update(self, carried, problem, state, t, effort):
        _, after, *others = self._with_last_maximum(carried)
        return after, (state.u, state.v), *others

    def result(self, carried, problem, state):
        *_, maxima, first, last = self._with_last_maximum(carried)
        first, last = (self._amplitude(problem, *end) for end in (first, last))
        periods = maxima.astype(float) - 1
        return {"amplitude_decay": jnp.where(maxima > 1, 1 - (last / first) ** (1 / periods), jnp.nan)}

    def _amplitude(self, problem, before, after):
        root = _root(_quintic(problem, before, after, self.dt, derivative=True))
        return value(_quintic(problem, before, after, self.dt), root) - self.rest
