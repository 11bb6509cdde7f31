"""The KR-α method."""

import jax.numpy as jnp
import numpy as np
import pytest

import study


@pytest.mark.parametrize(
    "scheme, factor, stable",
    [(1.0, 1.0, True), (1.0, 4.0, True), (1.0, 5.5, False), (0.8, 0.5, True), (0.8, 1.0, True), (0.8, 1.5, False)],
)
def test_stability_of_kr_alpha_is_that_of_its_model(scheme, factor, stable):
    """With ρ∞ = 1 stiffnesses up to 4/Δt² + K are stable; with ρ∞ = 0.8 those above K, as in hardening, are not."""
    dt, rest = 1.0, 1.0
    # a spring whose tangent is 1 at rest and `factor` away from it
    problem = study.Problem(lambda u: jnp.where(jnp.abs(u) < 1e-6, rest, factor) * u, u0=1.0)
    ds = study.run(problem, study.KolayRicles(scheme), dt=dt, steps=2000)
    assert (np.abs(ds.u).max() < 100) == stable
