"""Springs of one unknown."""

import jax
import mpmath
import numpy as np
import pytest

import study


@pytest.mark.slow
def test_the_potential_of_the_softening_spring_leaves_round_off():
    """The potential is a difference of |u| and a logarithm; its round-off must not exceed the round-off of |u|."""
    u = np.concatenate([[0.0], np.geomspace(1e-8, 700, 300), -np.geomspace(1e-3, 30, 100)])
    with mpmath.workdps(40):
        exact = np.array([float(100 * mpmath.log(mpmath.cosh(mpmath.mpf(x)))) for x in u])
    potential = study.problems["softening"].potential
    assert potential is not None
    assert np.all(np.abs(jax.vmap(potential)(u) - exact) <= 8e-16 * 100 * np.abs(u))
    np.testing.assert_allclose(jax.vmap(jax.grad(potential))(u), 100 * np.tanh(u), atol=1e-13)
