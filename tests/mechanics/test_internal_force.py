"""Detected properties of a force: its number of arguments, whether it uses them, and its kinks."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.mechanics.internal_force import depends_on_last, may_have_kinks, number_of_arguments, switches


@pytest.mark.parametrize(
    "force, kinked",
    [
        (lambda u: u**3, False),
        (jnp.sin, False),
        (lambda u: jnp.where(u > 0, u, 0.0), True),
        (lambda u: jnp.maximum(u, 0.0), True),
        (lambda u: jnp.abs(u) * u, True),
        (lambda u: u * (u > 0).astype(float), True),
        (lambda u: jnp.max(jnp.stack([u, 2 * u])), True),
        (lambda u: jnp.clip(u, -1.0, 1.0), True),
        (lambda u: jnp.interp(u, jnp.array([0.0, 1.0]), jnp.array([0.0, 2.0])), True),
        (jax.jit(lambda u: jax.lax.cond(u > 0, lambda: u, lambda: 2 * u)), True),
        (lambda u: jnp.where(jnp.arange(2.0) > 0, 1.0, 2.0).sum() * u, False),
    ],
)
def test_kinks_are_seen(force, kinked):
    assert may_have_kinks(force, 0.5) is kinked
    assert study.Problem(force, u0=0.5).kinked is kinked


@pytest.mark.parametrize(
    "force, arguments, expected",
    [
        (lambda u: u**3 + jnp.cos(u), (0.3,), []),
        (lambda u: u * jnp.max(jnp.arange(3.0)), (0.3,), []),
        (lambda u: jnp.maximum(u - 0.5, 0.0), (0.3,), [-0.2]),
        (study.materials.gap(stiffness=7.0, opening=0.1), (0.3,), [0.2]),
        (lambda u: jnp.where(2 * u > 1, u, 3 * u) + jnp.abs(u), (0.3,), [-0.4, 0.3]),
        (lambda u: jnp.clip(u, -1.0, 1.0), (0.3,), [-1.3, 0.7]),
        (lambda u: jax.lax.clamp(-1.0, u, 1.0), (0.3,), [1.3, -0.7]),
        (lambda u: jax.nn.relu(u + 1) + jax.nn.relu(u), (0.3,), [1.3, 0.3]),
        (lambda u: jnp.minimum(u, jnp.array([0.0, 0.5])), ([0.3, 0.3],), [0.3, -0.2]),
        (lambda u, v: u + jnp.abs(v) * v, (0.3, -2.0), [-2.0]),
    ],
)
def test_switches_change_their_sign_at_kinks(force, arguments, expected):
    values = switches(force, *map(jnp.asarray, arguments))
    np.testing.assert_allclose(np.sort(np.abs(values)), np.sort(np.abs(expected)), atol=1e-15)


@pytest.mark.slow
def test_smooth_problems_of_the_study_are_seen_as_smooth():
    """A problem without kinks is not taken for one with kinks, whose iteration takes longer to compile."""
    kinked = [name for name in study.problems if study.problems[name].kinked]
    # the load on the beam ends smoothly, but its formula has a branch
    assert sorted(kinked) == ["belt", "bouncing", "elastic_beam", "hysteretic", "yielding"]


@pytest.mark.parametrize(
    "force, arguments",
    [
        (lambda u: u, 1),
        (lambda u, k=2.0: u, 1),
        (lambda u, v: u, 2),
        (lambda u, v, history: u, 3),
        (functools.partial(lambda k, u: u, 2.0), 1),
        (np.sin, 1),
        (jax.jit(lambda u, v: u), 2),
        (study.materials.elastoplastic(stiffness=1.0, yield_force=1.0), 3),
    ],
)
def test_arguments_are_counted(force, arguments):
    assert number_of_arguments(force) == arguments


def test_an_unused_velocity_is_seen():
    assert depends_on_last(lambda u, v: u * v, 1.0, 1.0)
    assert not depends_on_last(lambda u, v: u, 1.0, 1.0)
    assert not depends_on_last(jax.jit(lambda u, v: u**2), 1.0, 1.0)
