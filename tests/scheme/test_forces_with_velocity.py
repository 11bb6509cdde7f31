"""Forces that depend on the velocity: linear forces equal damping, and nonlinear ones keep the order of schemes."""

from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest

import study
from tests.scheme.test_convergence import SIXTH, STEPS, motion


@cache
def _with_damping_or_the_force_of_a_velocity(tangent):
    n, coefficients = 6, np.linspace(0.2, 0.8, 6)

    def force(u):
        return jnp.arange(1.0, n + 1) * u + u**3

    u0 = np.linspace(-1, 1, n)
    damped = study.Problem(force, u0=u0, damping=coefficients, tangent=tangent)
    return damped, study.Problem(lambda u, v: force(u) + coefficients * v, u0=u0, tangent=tangent)


@pytest.mark.parametrize("tangent", ["dense", "diagonal"])
@pytest.mark.parametrize("name", ["average_acceleration", "central_difference", "gauss4", "kr_alpha", "houbolt"])
def test_a_force_linear_in_the_velocity_is_damping(name, tangent):
    """A tangent that lacks the part of the velocity in one scheme."""
    problems = _with_damping_or_the_force_of_a_velocity(tangent)
    expected, observed = (study.run(problem, name, dt=0.05, steps=100) for problem in problems)
    np.testing.assert_allclose(expected.u, observed.u, atol=5e-14)
    np.testing.assert_allclose(expected.v, observed.v, atol=5e-13)


@pytest.mark.slow
def test_the_order_with_quadratic_drag(sampled_kind):
    scheme = SIXTH if study.schemes[sampled_kind].order == 12 else study.schemes[sampled_kind]
    if scheme.title == study.schemes["energy_momentum"].title:
        pytest.skip("takes the force from a potential")
    if sampled_kind == "dormand_prince6":
        pytest.skip("its error reaches round-off before it falls with its order; it does so with damping")

    def force(u, v):
        return 2 * u + u**3 + 0.3 * v * jnp.sqrt(1 + v**2)

    def load(t):
        u, v, a = motion(t)
        return a + force(u, v)

    u0, v0, _ = motion(0.0)
    problem = study.Problem(force, u0, v0, load=load)
    steps, errors = STEPS[scheme.order_with_damping], []
    for n in steps:
        end = study.run(problem, scheme, dt=3.0 / n, steps=n, every=n).isel(t=-1)
        errors.append(abs(float(end.u) - float(motion(3.0)[0])))
    orders = -np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert orders == pytest.approx(scheme.order_with_damping, abs=0.15)


def test_a_force_without_velocity_compiles_as_before():
    """A velocity argument that the force does not use makes a problem neither damped nor iterative."""
    problem = study.Problem(lambda u, v: 4 * u, u0=1.0)
    assert problem.arguments == 2 and not problem.takes_velocity and not problem.damped
    iterations = study.run(problem, "central_difference", dt=0.1, steps=10, observe=["newton_iterations"])
    assert int(iterations.newton_iterations) == 0


def test_an_energy_from_a_potential_alone_is_refused():
    problem = study.Problem(lambda u, v: u + v, u0=1.0, potential=lambda u: u**2 / 2)
    with pytest.raises(ValueError, match="'Energy-momentum' takes the force from the potential, and the force of"):
        study.run(problem, "energy_momentum", dt=0.1, steps=1)
