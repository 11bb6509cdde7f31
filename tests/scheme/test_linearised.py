"""Linearised steps, which carry the distance to a neighbouring motion along."""

import dataclasses
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.scheme.wrapper.linearised import Linearised


@pytest.mark.slow
def test_the_derivative_of_a_step_is_that_of_differences(state_kind):
    scheme, problem, dt = study.schemes[state_kind], study.problems["hardening"], jnp.asarray(0.012)
    state, _ = jax.jit(partial(scheme.start, problem))(jnp.asarray(1.1), jnp.asarray(3.0), dt)
    direction = jax.tree.map(lambda part: 0.3 * jnp.ones_like(part), state)

    @jax.jit
    def step(state):
        return scheme.step(problem, state, jnp.asarray(0.0), dt)[0]

    def moved(part):
        return jax.tree.leaves(step(jax.tree.map(lambda x, d: x + part * d, state, direction)))

    _, tangent = jax.jit(lambda *along: jax.jvp(step, *along))((state,), (direction,))
    for exact, ahead, behind in zip(jax.tree.leaves(tangent), moved(1e-5), moved(-1e-5), strict=True):
        np.testing.assert_allclose(exact, (ahead - behind) / 2e-5, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_a_neighbour_that_a_step_has_brought_to_the_run_stays_with_it():
    scheme, problem, dt = Linearised(scheme=study.schemes["rk4"]), study.problems["hardening"], jnp.asarray(0.01)
    start, _ = scheme.start(problem, jnp.asarray(1.0), jnp.asarray(0.0), dt)
    together = dataclasses.replace(start, distance=jax.tree.map(jnp.zeros_like, start.distance))
    state, _ = scheme.step(problem, together, jnp.asarray(0.0), dt)
    assert all(part == 0 for part in jax.tree.leaves(state.distance))


def test_the_exponent_counts_the_growth_that_is_taken_from_the_distance():
    """Beyond its limit of stability, central difference multiplies the distance by the spectral radius each step."""
    spring, dt, steps = study.Problem(lambda u: 4.0 * u, 1.0, 0.0), jnp.asarray(2.0), 40
    scheme = Linearised(scheme=study.schemes["central_difference"])
    state, _ = scheme.start(spring, jnp.asarray(1.0), jnp.asarray(0.0), dt)
    sizes = []
    for step in range(steps):
        state, _ = scheme.step(spring, state, step * dt, dt)
        sizes.append(float(jnp.log2(jnp.abs(state.distance.u))) + float(state.exponent))
    radius = float(study.LinearTheory("central_difference", np.array([4.0 / (2 * np.pi)])).spectral_radius.item())
    np.testing.assert_allclose(np.diff(sizes)[10:], np.log2(radius), rtol=1e-9)
