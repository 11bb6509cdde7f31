"""Newton's iteration: its convergence, its failures, and its safeguard."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

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
    """On the steep side of an exponential each iteration reduces the exponent by one only."""
    problem = study.Problem(jnp.expm1, u0=1.0)
    a, effort = balance(problem, *map(jnp.asarray, (0.0, 0.5, 0.0, 1.0, 0.0, 40.0)))
    assert effort.converged and 40 < effort.iterations < MAX_ITERATIONS
    assert float(a + problem.force(0.5 + a)) == pytest.approx(0.0, abs=1e-15)


def _corrected(spring, u, c_u, a):
    """Accelerations after one more Newton iteration, and its corrections relative to the displacement."""
    force, tangent = jax.jvp(jax.vmap(spring.force), (u + c_u * a,), (jnp.ones_like(u),))
    correction = (a + force) / (1 + c_u * tangent)
    a = a - correction
    return a, jnp.abs(c_u * correction) / (jnp.abs(u) + jnp.abs(c_u * a))


@pytest.mark.slow
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
    """For the cube root of the displacement as the force, Newton's iteration fails within its bound on iterations."""
    problem = study.Problem(lambda u: jnp.cbrt(u), u0=1.0)
    _, effort = balance(problem, 0.0, jnp.asarray(1.0), jnp.asarray(0.0), 1e9, 1.0, jnp.asarray(1.0))
    assert not effort.converged
    assert effort.iterations <= MAX_ITERATIONS


@pytest.mark.parametrize("u, guess", [(1.0, 1.0), (-3.0, 50.0), (1e-3, 0.0)])
def test_a_safeguard_finds_the_root_where_newton_jumps_from_side_to_side(u, guess):
    problem = study.Problem(lambda u: jnp.cbrt(u), u0=1.0).with_safeguard()
    a, effort = balance(problem, *map(jnp.asarray, (0.0, u, 0.0, 1e9, 1.0, guess)))
    assert effort.converged and effort.restarts == 1
    root = brentq(lambda a: a + np.cbrt(u + 1e9 * a), -1e6, 1e6, xtol=1e-30, rtol=1e-15)
    assert float(u + 1e9 * a) == pytest.approx(u + 1e9 * root, rel=1e-9, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "wilson_theta", "houbolt", "bathe", "energy_momentum"])
def test_every_step_of_a_rising_force_has_its_root(scheme):
    """Restarts find the root of each step; without restarts, Newton's iteration fails at the larger step sizes."""
    dt = 1.79 * np.logspace(-1, 0, 24)
    ds = study.run("softening_large", scheme, dt=dt, steps=200, observe=["max_energy_error"])
    assert not ds.status.any() and ds.newton_restarts.max() > 0
    if scheme == "energy_momentum":
        assert ds.max_energy_error.max() < 1e-8


@pytest.mark.slow
def test_a_family_and_several_unknowns_have_the_safeguard_too():
    """A safeguard that only single runs of one unknown have."""

    def springs(scale):
        return study.Problem(lambda u: 100.0 * jnp.tanh(u), u0=scale * jnp.array([4.0, -3.0, 2.0]))

    scale, arguments = [0.01, 1.0, 2.0], {"dt": 0.5, "steps": 100, "observe": "newton_iterations"}
    family = study.run(springs, "average_acceleration", over={"scale": scale}, **arguments)
    alone = [study.run(springs(factor), "average_acceleration", **arguments) for factor in scale]
    assert not family.status.any() and family.newton_restarts[0] == 0 < family.newton_restarts[2]
    assert [int(run.status) for run in alone] == [0, 0, 0]


def test_a_number_that_is_not_finite_ends_the_iteration():
    problem = study.Problem(lambda u: jnp.log(u), u0=1.0)
    a, effort = balance(problem, 0.0, jnp.asarray(-1.0), jnp.asarray(0.0), 0.1, 1.0, jnp.asarray(0.0))
    assert np.isnan(a)
    assert effort.iterations == 2
