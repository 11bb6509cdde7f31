"""The amplification matrix of the code against closed forms, and against the run itself."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.experiments.spectral import amplification_matrix

PARTS = np.array([0.01, 0.05, 0.1, 0.3, 1.0, 10.0])


def _eigenvalues(scheme, part, damping_ratio=0.0):
    return np.linalg.eigvals(np.asarray(amplification_matrix(scheme, part, damping_ratio)))


@pytest.mark.parametrize("part", PARTS)
def test_average_acceleration_neither_damps_nor_grows(part):
    """λ = (1 ± iΩ/2)/(1 ∓ iΩ/2), the trapezoidal rule."""
    half = 1j * np.pi * part
    expected = (1 + half) / (1 - half)
    distance = min(abs(_eigenvalues(study.schemes["average_acceleration"], part) - expected))
    assert distance < 1e-10


def test_central_difference_is_stable_up_to_two():
    below, above = (np.abs(_eigenvalues(study.schemes["central_difference"], x / np.pi)).max() for x in (0.999, 1.001))
    assert below == pytest.approx(1.0, abs=1e-10)
    assert above > 1.05


def test_runge_kutta_is_the_exponential_series():
    """λ = 1 + z + z²/2 + z³/6 + z⁴/24 with z = iΩ, stable up to Ω = 2√2."""
    for part in PARTS:
        z = 2j * np.pi * part
        expected = 1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24
        found = _eigenvalues(study.schemes["rk4"], part)
        assert min(abs(found - expected)) < 1e-10 * abs(expected)
    limit = np.sqrt(2) / np.pi
    below, above = (np.abs(_eigenvalues(study.schemes["rk4"], x * limit)).max() for x in (0.999, 1.001))
    assert below < 1 < above


@pytest.mark.parametrize("part", PARTS)
def test_houbolt_has_its_polynomial(part):
    """(2 + Ω²) λ³ − 5λ² + 4λ − 1 = 0 without damping."""
    omega = 2 * np.pi * part
    expected = np.roots([2 + omega**2, -5, 4, -1])
    found = _eigenvalues(study.schemes["houbolt"], part)
    for root in expected:
        assert min(abs(found - root)) < 1e-7  # the matrix has further, defective zeros
    assert np.abs(found).max() == pytest.approx(np.abs(expected).max(), abs=1e-10)


@pytest.mark.parametrize("alpha", [0.0, -0.1, -0.3])
def test_hht_has_its_limit_of_high_frequency(alpha):
    """ρ∞ = (1 + α)/(1 − α) for β = (1 − α)²/4 and γ = ½ − α."""
    scheme = study.HHTAlpha(alpha=alpha, beta=(1 - alpha) ** 2 / 4, gamma=0.5 - alpha)
    radius = np.abs(_eigenvalues(scheme, 1e5)).max()
    assert radius == pytest.approx((1 + alpha) / (1 - alpha), abs=1e-4)


@pytest.mark.parametrize("theta, stable", [(1.36, False), (1.37, True), (1.4, True)])
def test_wilson_is_unconditionally_stable_from_1_366(theta, stable):
    radii = [np.abs(_eigenvalues(study.WilsonTheta(theta=theta), part)).max() for part in (1.0, 10.0, 1e3)]
    assert (max(radii) <= 1 + 1e-12) == stable


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_the_run_is_the_power_of_the_matrix(scheme, damping_ratio):
    """On the linear oscillator n steps are the n-th power of the amplification matrix."""
    dt = 0.3
    problem = study.Problem(lambda u: u, u0=1.0, v0=0.5, damping=2 * damping_ratio if damping_ratio else None)
    ds = study.run(problem, scheme, dt=dt, steps=20)
    start, _ = scheme.start(problem, jnp.asarray(1.0), jnp.asarray(0.5), dt)
    matrix = np.asarray(amplification_matrix(scheme, dt / (2 * np.pi), damping_ratio))
    states = [np.asarray(start)]
    for _ in range(20):
        states.append(matrix @ states[-1])
    np.testing.assert_allclose(ds.u, np.stack(states)[:, 0], atol=1e-12)
    np.testing.assert_allclose(ds.v, np.stack(states)[:, 1], atol=1e-12)


def test_damping_of_the_oscillator_is_seen(scheme):
    """With 10 % damping the spectral radius at small steps is exp(−ξΩ)."""
    omega = 2 * np.pi * 1e-3
    radius = np.abs(_eigenvalues(scheme, 1e-3, 0.1)).max()
    assert radius == pytest.approx(np.exp(-0.1 * omega), abs=5e-6)
