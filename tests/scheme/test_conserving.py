"""Schemes that conserve the energy or the momenta."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study


@pytest.mark.slow
@pytest.mark.parametrize("name", ["energy_momentum", "average_vector_field"])
@pytest.mark.parametrize("problem, dt", [("hardening", 0.15 / 8), ("double_well", 2.5)])
def test_energy_of_a_quartic_is_conserved_to_round_off(name, problem, dt):
    """The energy is kept at step sizes at which the energy error of average acceleration exceeds one per cent."""
    ds = study.run(problem, name, dt=dt, steps=20_000, observe=["max_energy_error"])
    assert ds.status == 0
    assert ds.max_energy_error < 1e-10
    average = study.run(problem, "average_acceleration", dt=dt, steps=20_000, observe=["max_energy_error"])
    assert average.max_energy_error > 0.01


@pytest.mark.slow
def test_energy_of_any_potential_is_conserved_by_the_discrete_gradient_alone():
    gradient, quadrature = (
        study.run("softening", name, dt=1.14 / 8, steps=20_000, observe=["max_energy_error"]).max_energy_error
        for name in ("energy_momentum", "average_vector_field")
    )
    assert gradient < 1e-10 < 1e-5 < quadrature


@pytest.mark.slow
def test_conservation_of_two_masses_on_a_spring():
    """In the plane the midpoint rule conserves linear and angular momentum, and the discrete gradient the energy."""

    def potential(x):
        length = jnp.sqrt((x[0] - x[2]) ** 2 + (x[1] - x[3]) ** 2)
        return 50 * (length - 1) ** 2

    mass, start, speed = np.array([1.0, 1.0, 2.0, 2.0]), np.array([0.0, 0.0, 1.5, 0.0]), np.array([0.3, 1.0, 0.0, -0.4])
    problem = study.Problem(jax.grad(potential), start, speed, potential=potential, mass=mass)
    midpoint, gradient = (
        study.run(problem, name, dt=0.05, steps=1000, observe=["trajectory", "energy_error"])
        for name in ("implicit_midpoint", "energy_momentum")
    )
    u, momentum = midpoint.u.values, mass * midpoint.v.values
    linear = momentum[:, :2] + momentum[:, 2:]
    spin = u[:, 0] * momentum[:, 1] - u[:, 1] * momentum[:, 0] + u[:, 2] * momentum[:, 3] - u[:, 3] * momentum[:, 2]
    np.testing.assert_allclose(linear - linear[0], 0, atol=1e-10)
    np.testing.assert_allclose(spin, spin[0], atol=1e-10)
    assert abs(gradient.energy_error).max() < 1e-11
    assert abs(midpoint.energy_error).max() > 1e-2


def test_the_discrete_gradient_needs_a_potential():
    with pytest.raises(ValueError, match="'Energy-momentum' needs the potential of 'unnamed problem'"):
        study.run(study.Problem(lambda u: u, u0=1.0), "energy_momentum", dt=0.1, steps=1)


@pytest.mark.slow
def test_the_energy_momentum_method_converges_at_small_amplitude_too():
    """Runs succeed at small amplitude, where the potential of the softening spring is a difference of large numbers."""
    u0 = np.array([0.126, 0.141, 0.175, 0.195])
    runs = study.run(
        "softening", "energy_momentum", dt=0.6290 / 256, u0=u0, steps=100_000, observe=["max_energy_error"]
    )
    assert (runs.status == 0).all()
