"""Errors of linear and angular momentum."""

import jax.numpy as jnp

from study.observer.base import Reduction
from study.problem.definition import Problem


def _momenta(problem: Problem, state):
    """Linear and angular momentum of every point, of shape (points, directions) and (points, 3)."""
    points, directions = jnp.shape(problem.positions)
    p = problem.momentum(state.v).reshape(points, directions)
    x = problem.positions + state.u.reshape(points, directions)
    in_space = [(0, 0), (0, 3 - directions)]
    return p, jnp.cross(jnp.pad(x, in_space), jnp.pad(p, in_space))


class MomentumErrors(Reduction):
    """Largest change of total linear and angular momentum, each relative to the largest sum over points of |momentum|.

    NaN if no point has any.
    """

    variables = {
        "max_linear_momentum_error": {"long_name": "largest change of linear momentum, relative", "units": "1"},
        "max_angular_momentum_error": {"long_name": "largest change of angular momentum, relative", "units": "1"},
    }
    needs_positions = True

    def start(self, problem, state):
        momenta = _momenta(problem, state)
        return [m.sum(axis=0) for m in momenta], jnp.zeros(2), jnp.stack([_sizes(m) for m in momenta])

    def update(self, carried, problem, state, t, effort):
        at_start, errors, scales = carried
        momenta = _momenta(problem, state)
        changes = [jnp.linalg.norm(m.sum(axis=0) - before) for m, before in zip(momenta, at_start, strict=True)]
        return (
            at_start,
            jnp.maximum(errors, jnp.stack(changes)),
            jnp.maximum(scales, jnp.stack([_sizes(m) for m in momenta])),
        )

    def result(self, carried, problem, state):
        _, errors, scales = carried
        return dict(zip(self.variables, errors / scales, strict=True))


def _sizes(momenta):
    """Sum over points of |momentum|."""
    return jnp.linalg.norm(momenta, axis=1).sum()
