"""Newton's iteration: how fast it converges, and what it reports when it fails."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.mechanics.balance import balance
from study.mechanics.newton import MAX_ITERATIONS
from study.problem.named import printed_periods


def test_convergence_is_quadratic_down_to_round_off():
    problem = study.problems["hardening"]
    a, effort = balance(problem, 0.0, jnp.asarray(1.5), jnp.asarray(0.0), 1e-4, 1e-2, jnp.asarray(-3000.0))
    assert effort.iterations <= 6
    assert float(a + problem.force(1.5 + 1e-4 * a)) == pytest.approx(0.0, abs=1e-11 * abs(float(a)))


def test_a_far_guess_is_given_the_iterations_that_it_needs():
    """On the steep side of an exponential each iteration comes nearer by one unit of the exponent."""
    problem = study.Problem(jnp.expm1, u0=1.0)
    a, effort = balance(problem, *map(jnp.asarray, (0.0, 0.5, 0.0, 1.0, 0.0, 40.0)))
    assert effort.converged and 40 < effort.iterations < MAX_ITERATIONS
    assert float(a + problem.force(0.5 + a)) == pytest.approx(0.0, abs=1e-15)


def _corrected(spring, u, c_u, a):
    """One more Newton iteration, and its correction relative to the displacement."""
    force, tangent = jax.jvp(jax.vmap(spring.force), (u + c_u * a,), (jnp.ones_like(u),))
    correction = (a + force) / (1 + c_u * tangent)
    a = a - correction
    return a, jnp.abs(c_u * correction) / (jnp.abs(u) + jnp.abs(c_u * a))


@pytest.mark.parametrize("problem, steps_per_period", [("hardening", 40), ("hardening", 60), ("softening", 40)])
def test_no_third_correction_if_it_is_predicted_to_be_round_off(problem, steps_per_period):
    spring, c_u = study.problems[problem], (printed_periods[problem] / steps_per_period) ** 2 / 4
    u0 = jnp.linspace(0.3, 1.0, 64) * spring.u0
    guess = -jax.vmap(spring.force)(u0)
    u = u0 + c_u * guess
    a, effort = jax.vmap(lambda u, guess: balance(spring, 0.0, u, jnp.zeros(()), c_u, 0.0, guess))(u, guess)
    once, _ = _corrected(spring, u, c_u, guess)
    _, second = _corrected(spring, u, c_u, once)
    assert np.all(effort.iterations == 2) and second.max() > 1e-12
    _, third = _corrected(spring, u, c_u, a)
    assert third.max() < 1e-15


def test_failure_is_reported_within_the_bound():
    """Under a force like a root of the displacement the iteration jumps from side to side for ever."""
    problem = study.Problem(lambda u: jnp.cbrt(u), u0=1.0)
    _, effort = balance(problem, 0.0, jnp.asarray(1.0), jnp.asarray(0.0), 1e9, 1.0, jnp.asarray(1.0))
    assert not effort.converged
    assert effort.iterations <= MAX_ITERATIONS


def test_a_number_that_is_not_finite_ends_the_iteration():
    problem = study.Problem(lambda u: jnp.log(u), u0=1.0)
    a, effort = balance(problem, 0.0, jnp.asarray(-1.0), jnp.asarray(0.0), 0.1, 1.0, jnp.asarray(0.0))
    assert np.isnan(a)
    assert effort.iterations == 2
