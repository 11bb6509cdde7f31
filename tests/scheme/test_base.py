"""What schemes say of themselves."""

import jax
import jax.numpy as jnp
import numpy as np

import study


def test_forces_are_counted(scheme):
    """Against a force and a potential that count their evaluations in a step."""
    calls: list[jax.Array] = []

    def counted(function):
        def call(u):
            jax.debug.callback(calls.append, u)
            return function(u)

        return call

    force, potential = counted(lambda u: 100 * u + 1000 * u**3), counted(lambda u: (50 * u**2 + 250 * u**4).sum())
    problem = study.Problem(force, u0=[1.5, 1.0], v0=[0.0, 0.0], potential=potential)
    state, _ = scheme.start(problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), jnp.asarray(1e-3))
    jax.effects_barrier()
    calls.clear()
    _, effort = scheme.step(problem, state, 0.0, jnp.asarray(1e-3))
    jax.effects_barrier()
    # the stiffness at u = 0, of which KR-α makes its model, is the same in every step
    evaluated = [u for u in calls if np.any(u)]
    assert len(evaluated) == scheme.evaluations + int(effort.iterations) * scheme.evaluations_per_iteration
