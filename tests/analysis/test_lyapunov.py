"""Lyapunov exponents of schemes, against closed forms and another way to compute them."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.analysis.lyapunov import statistics
from study.mechanics.loads import HarmonicLoad


def test_a_damped_linear_oscillator_has_the_exponents_of_its_roots():
    """Exponents are −c/2 for each root below critical damping, and ln|λ|/Δt of the scheme; the mean square is known."""
    spring = study.Problem(lambda u: u, 1.0, damping=0.2, load=HarmonicLoad(1.0, frequency=2.0, phase=0.0))
    estimate = statistics(spring, study.schemes["average_acceleration"], np.array([[1.0], [2.0]]), np.pi, 16, 120, 40)
    theory = study.LinearTheory("average_acceleration", np.array([1 / 32]), damping_ratio=0.1)
    rate = np.log(theory.spectral_radius) / (np.pi / 16)
    np.testing.assert_allclose(estimate.exponents, np.broadcast_to(rate, (2, 2)), atol=3e-4)
    np.testing.assert_allclose(estimate.exponents.sum(axis=1), 2 * rate.item(), rtol=1e-9)
    # the amplitude 1/√((1 − Ω²)² + (cΩ)²) with the frequency 2 tan(ΩΔt/2)/Δt that the scheme sees
    seen = 2 * np.tan(np.pi / 16) / (np.pi / 16)
    np.testing.assert_allclose(estimate.mean_square, 0.5 / ((1 - seen**2) ** 2 + (0.2 * seen) ** 2), rtol=1e-3)


@pytest.mark.parametrize("name", ["ueda", "buckled_beam"])
def test_the_exponents_of_central_difference_add_up_to_minus_the_damping(name):
    """A step of central difference contracts volumes by (1 − cΔt/2)/(1 + cΔt/2) for each unknown, wherever it is."""
    problem = study.problems[name]
    period, u0 = study.problem.named.time_scales[name], np.tile(np.ravel(problem.u0), (2, 1))
    estimate = statistics(problem, study.schemes["central_difference"], u0, period, 32, 40, 10)
    c, dt = problem.damping, period / 32
    exact = u0.shape[1] * np.log((1 - c * dt / 2) / (1 + c * dt / 2)) / dt
    np.testing.assert_allclose(estimate.exponents.sum(axis=1), exact, rtol=1e-6)
    assert (np.diff(estimate.exponents.mean(axis=0)) < 0.1).all()


def test_the_largest_exponent_is_that_of_a_run():
    """The exponent of ``study.run`` follows one vector; both agree within the first turns of the vectors."""
    steps, runs = 200, np.array([2.5, 3.0])
    estimate = statistics(study.problems["ueda"], study.schemes["rk4"], runs[:, None], 2 * np.pi, 64, steps, 0)
    run = study.run("ueda", "rk4", dt=2 * np.pi / 64, steps=64 * steps, u0=runs, observe=["lyapunov_exponent"])
    np.testing.assert_allclose(estimate.exponents[:, 0], run.lyapunov_exponent, atol=3 / (2 * np.pi * steps))
    assert jnp.isfinite(estimate.mean_square).all()
