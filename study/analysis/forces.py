"""Numbers of forces that a step of a scheme evaluates, counted in a traced step."""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from study.algebra.counting import counting
from study.mechanics.definition import Problem
from study.scheme.base import Scheme


class ForcesOfStep(NamedTuple):
    """Number of forces per step in addition to Newton's iterations, and number of forces per Newton iteration."""

    per_step: int
    per_iteration: int


def forces_of(scheme: Scheme, several: bool = True) -> ForcesOfStep:
    """Forces that a step evaluates on two springs p = u + u³, or on one; a potential counts as a force.

    A discrete gradient needs fewer evaluations with one unknown.
    """
    u0 = jnp.ones(2 if several else ())
    springs = Problem(lambda u: u + u**3, u0, potential=lambda u: jnp.sum(u**2 / 2 + u**4 / 4))
    v0, dt = jnp.zeros_like(u0), jnp.asarray(0.1)
    state = jax.eval_shape(lambda: scheme.start(springs, u0, v0, dt)[0])
    with counting() as counts:
        jax.eval_shape(lambda state: scheme.step(springs, state, dt, dt), state)
    return ForcesOfStep(counts.forces, counts.forces_of_iteration)
