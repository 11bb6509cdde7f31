"""The sensitivity to round-off, compared with the errors of evaluations in single precision."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from study.algebra.round_off import sensitivity


def _elongation(u):
    """Elongation of a bar from (0, 0) to (3 + u₀, 4 + u₁), whose length was 5."""
    return jnp.stack([jnp.sqrt((3 + u[0]) ** 2 + (4 + u[1]) ** 2) - 5, u[0] + u[1]])


@pytest.mark.parametrize("size", [1e-1, 1e-4, 1e-8, 1e-12])
def test_the_sensitivity_of_an_elongation_is_that_of_its_length(size):
    u = jnp.array([size, 0.3 * size])
    long, small = np.asarray(sensitivity(_elongation, u, _elongation(u)))
    assert 5 < long < 100
    assert size < small < 20 * size


def test_the_error_of_single_precision_is_its_epsilon_times_the_sensitivity():
    random = np.random.default_rng(0)
    points = random.normal(size=(200, 2)) * 1e-3
    bound = jax.jit(lambda u: sensitivity(_elongation, u, _elongation(u)))
    errors, bounds = [], []
    for u in points.astype(np.float32):
        exact = _elongation(jnp.asarray(u, float))
        with jax.enable_x64(False):
            errors.append(np.asarray(_elongation(jnp.asarray(u))) - np.asarray(exact))
        bounds.append(np.asarray(bound(jnp.asarray(u, float))))
    ratio = np.abs(errors).max(axis=0) / (np.finfo(np.float32).eps * np.median(bounds, axis=0))
    assert 0.01 < ratio[0] < 1 and ratio[1] < 1
