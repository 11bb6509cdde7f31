"""Upward crossings of a level, and their mean period."""

from functools import partial

import jax
import jax.numpy as jnp

from study.observer.base import Reduction


def crosses_upwards(before, after, level):
    """Whether u rises from below a level to it or beyond it, for each unknown."""
    return (before < level) & (after >= level)


def _crossing(before, after, dt, level):
    """Fraction 0 < s ≤ 1 of a step after which u reaches the level, for each unknown.

    Time as a function of u is interpolated by the cubic with the times and slopes 1/u̇ at both ends of the step. The
    slopes are limited so that the cubic is monotonic (Fritsch and Carlson, 1980). The error of s is of fourth order in
    the step.
    """
    (u0, v0), (u1, v1) = before, after
    way = jnp.where(u1 > u0, u1 - u0, 1.0)
    x = (level - u0) / way
    start, end = (jnp.clip(way / (dt * v), 0.0, 3.0) for v in (v0, v1))
    return x * x * (3 - 2 * x) + x * (1 - x) * (start * (1 - x) - end * x)


class Oscillations(Reduction):
    r"""Upward crossings of a level by each unknown: their number, the last one, and their mean period.

    Crossing i comes at the time (k_i + s_i) Δt, where k_i is a whole number of steps. The fraction 0 < s_i ≤ 1 of a
    step is interpolated by a cubic, from the displacements and velocities at both ends of the step. The mean period is

    .. math::

        T = \frac{(k_n - k_1) + (s_n - s_1)}{n - 1}\,\Delta t

    and NaN with fewer than two crossings. The error of interpolation does not grow with the length of the run. Whole
    steps are counted apart from fractions of a step, so that long runs lose no digits, also in single precision.

    Parameters
    ----------
    level
        Displacement that is crossed.

    References
    ----------
    F. N. Fritsch, R. E. Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer. Anal. 17(2), 1980, 238-246.
    """

    level: float = 0.0

    needs_equal_steps = True
    variables = {
        "crossings": {"long_name": "upward crossings", "units": "1"},
        "last_crossing_step": {"long_name": "whole steps before the last upward crossing", "units": "1"},
        "last_crossing_part": {"long_name": "part of a step from there to the last upward crossing", "units": "1"},
        "mean_period": {"long_name": "mean time between upward crossings", "units": "s"},
    }

    def start(self, problem, state):
        none, phase = jnp.zeros(state.u.shape, int), (state.u, state.v)
        never = none, phase, phase
        return (jnp.zeros((), int), jnp.zeros(())), phase, none, never, never

    def update(self, carried, problem, state, t, effort):
        (step, dt), before, crossings, first, last = carried
        dt, phase = jnp.where(step == 0, t, dt), (state.u, state.v)
        crossed = crosses_upwards(before[0], state.u, self.level)
        # both ends of the step are kept; only the first and the last crossing are interpolated, after the run
        last = jax.tree.map(partial(jnp.where, crossed), (step, before, phase), last)
        first = jax.tree.map(partial(jnp.where, crossings == 0), last, first)
        return (step + 1, dt), phase, crossings + crossed.astype(int), first, last

    def result(self, carried, problem, state):
        (_, dt), _, crossings, (first, *first_ends), (last, *last_ends) = carried
        parts = [_crossing(before, after, dt, self.level) for before, after in (first_ends, last_ends)]
        steps = (last - first).astype(float) + (parts[1] - parts[0])
        period = jnp.where(crossings > 1, dt * steps / (crossings - 1).astype(float), jnp.nan)
        return dict(zip(self.variables, (crossings, last, parts[1], period), strict=True))
