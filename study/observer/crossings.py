"""Upward crossings of a level, and their mean period."""

from functools import partial

import jax
import jax.numpy as jnp

from study.observer.base import Reduction


def _crossing(before, after, dt, level):
    """Where in 0 < s ≤ 1 a step comes up to a level, for each unknown.

    The inverse of the displacement is the cubic that has the step's displacements and, by the velocities, its slopes,
    which are kept within what leaves it monotonic (Fritsch and Carlson, 1980): s is of fourth order in the step.
    """
    (u0, v0), (u1, v1) = before, after
    way = jnp.where(u1 > u0, u1 - u0, 1.0)
    x = (level - u0) / way
    start, end = (jnp.clip(way / (dt * v), 0.0, 3.0) for v in (v0, v1))
    return x * x * (3 - 2 * x) + x * (1 - x) * (start * (1 - x) - end * x)


class Oscillations(Reduction):
    """Upward crossings of a level by each unknown: how many, when the last came, and their mean period.

    The crossing i comes at the time (k_i + s_i) Δt, with the step k_i as a whole number and the part s_i of a step by
    a cubic that displacements and velocities at both ends define; the mean period is ((k_n − k_1) + (s_n − s_1))
    Δt/(n − 1). What interpolation leaves does not grow with the length of the run, nor does single precision lose the
    count of the steps.

    Parameters
    ----------
    level
        The displacement that is crossed.
    """

    level: float = 0.0

    variables = {
        "crossings": {"long_name": "upward crossings", "units": "1"},
        "last_crossing_step": {"long_name": "whole steps before the last upward crossing", "units": "1"},
        "last_crossing_part": {"long_name": "part of a step from there to the last upward crossing", "units": "1"},
        "mean_period": {"long_name": "mean time between upward crossings", "units": "s"},
    }

    def start(self, problem, state):
        none, now = jnp.zeros(state.u.shape, int), (state.u, state.v)
        never = none, now, now
        return (jnp.zeros((), int), jnp.zeros(())), now, none, never, never

    def update(self, carried, problem, state, t, effort):
        (step, dt), before, crossings, first, last = carried
        dt, now = jnp.where(step == 0, t, dt), (state.u, state.v)
        crossed = (before[0] < self.level) & (state.u >= self.level)
        # interpolated at the end of the run only
        last = jax.tree.map(partial(jnp.where, crossed), (step, before, now), last)
        first = jax.tree.map(partial(jnp.where, crossings == 0), last, first)
        return (step + 1, dt), now, crossings + crossed.astype(int), first, last

    def result(self, carried, problem, state):
        (_, dt), _, crossings, (first, *start), (last, *end) = carried
        since_first, part = _crossing(*start, dt, self.level), _crossing(*end, dt, self.level)
        steps = (last - first).astype(float) + (part - since_first)
        period = jnp.where(crossings > 1, dt * steps / (crossings - 1).astype(float), jnp.nan)
        return dict(zip(self.variables, (crossings, last, part, period), strict=True))
