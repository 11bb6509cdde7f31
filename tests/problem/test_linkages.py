"""Rigid links in a row."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from study.problem.named import known


def _lagrangian(angle, rate):
    """Kinetic minus potential energy of two unit masses on unit rods, from the positions of the masses."""

    def positions(angle):
        first = jnp.stack([jnp.sin(angle[0]), -jnp.cos(angle[0])])
        return first, first + jnp.stack([jnp.sin(angle[1]), -jnp.cos(angle[1])])

    places, speeds = jax.jvp(positions, (angle,), (rate,))
    return sum(speed @ speed / 2 - place[1] for place, speed in zip(places, speeds, strict=True))


@jax.jit
def _rates(y):
    """Rates of angles and angular velocities, from Lagrange's equations of the second kind."""
    angle, rate = y[:2], y[2:]
    momentum = jax.grad(_lagrangian, 1)
    mass = jax.jacobian(momentum, 1)(angle, rate)
    generalized_force = jax.grad(_lagrangian)(angle, rate) - jax.jacobian(momentum)(angle, rate) @ rate
    return jnp.concatenate([rate, jnp.linalg.solve(mass, generalized_force)])


def test_the_double_pendulum_obeys_the_equations_of_lagrange():
    problem = study.problems["double_pendulum"]
    for y in np.random.default_rng(2).normal(size=(5, 4)):
        np.testing.assert_allclose(-problem.force(y[:2], y[2:]), _rates(y)[2:], rtol=1e-12)


@pytest.mark.slow
def test_the_double_pendulum_reaches_the_known_angles():
    target = known["double_pendulum"]
    problem = study.problems["double_pendulum"]
    start = [*problem.u0, *problem.v0]
    reference = solve_ivp(lambda t, y: np.asarray(_rates(y)), (0, target.time), start, "DOP853", rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(reference.y[:2, -1], target.u, rtol=0, atol=1e-11)
    ds = study.run(problem, "gauss4", dt=target.time / 4096, steps=4096, every=64)
    np.testing.assert_allclose(ds.u[-1], target.u, rtol=0, atol=1e-10)
    energies = [
        float(np.dot(jax.grad(_lagrangian, 1)(u, v), v) - _lagrangian(u, v))
        for u, v in zip(ds.u.values, ds.v.values, strict=True)
    ]
    np.testing.assert_allclose(energies, 0.0, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_the_elastic_beam_has_the_printed_angles():
    """An error in the equations of the beam, whose angles are known from its source alone."""
    target = known["elastic_beam"]
    problem = study.problems["elastic_beam"]
    end = study.run(problem, "gauss4", dt=target.time / 1024, steps=1024, every=1024).u.values[-1]
    np.testing.assert_allclose(end[:-1], target.u, rtol=0, atol=1e-6)
    assert end[-1] == np.float64(target.time)
