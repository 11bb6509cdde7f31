"""Schemes on several unknowns: results do not depend on the form of the tangent or on the coordinates."""

from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem.springs import CubicSpring

N, DT, STEPS = 5, 0.05, 20
EXHAUSTIVE = pytest.mark.exhaustive


def _elongations(u):
    return jnp.concatenate([u[:1], jnp.diff(u)])


def _hardening(strain):
    return strain * strain / 2 + strain**4 / 4


def _phase(problem, scheme, dt=DT, steps=STEPS, **arguments):
    ds = study.run(problem, scheme, dt=dt, steps=steps, **arguments)
    assert (ds.status == 0).all()
    return np.stack([ds.u.values, ds.v.values])


#: Schemes that solve the same linear systems as average acceleration, or none but with the mass.
ALIKE = ["hht_alpha_1996", "chung_lee"]
#: One scheme for each use of tangents and linear solutions.
WAYS = ["average_acceleration", *ALIKE, "kr_alpha", "energy_momentum", "gauss4"]


@pytest.fixture(scope="module")
def dense_motion(damped_chain):
    """Function that returns the motion of the chain by a scheme, with a dense tangent."""
    return cache(lambda scheme: _phase(damped_chain("dense"), scheme))


@pytest.mark.parametrize(
    "scheme, structure, tolerance",
    [
        *((scheme, "tridiagonal", 1e-11) for scheme in WAYS),
        ("kr_alpha", 2, 1e-11),
        # iterative linear solutions have ten digits
        *((scheme, "matrix_free", 1e-9) for scheme in WAYS if scheme not in ALIKE),
        *(pytest.param(scheme, "matrix_free", 1e-9, marks=EXHAUSTIVE) for scheme in ALIKE),
    ],
)
def test_the_form_of_the_tangent_makes_no_difference(damped_chain, dense_motion, scheme, structure, tolerance):
    """The motion of a damped and loaded chain is the same for every form of its tangent."""
    trajectory = _phase(damped_chain(structure), scheme)
    np.testing.assert_allclose(trajectory, dense_motion(scheme), rtol=0, atol=tolerance)


@pytest.fixture(scope="module")
def oscillators():
    """Oscillators that nothing couples, and one of them."""
    spring, common = CubicSpring(4.0, 0.5), {"mass": 2.0, "damping": 0.3}
    # an energy for each strain: the mean force of a single potential would couple the oscillators
    together = study.Problem(
        potential=study.StrainEnergy(lambda u: u, spring.potential), u0=np.linspace(-1, 2, N), v0=np.full(N, 0.5),
        tangent=0, load=lambda t: jnp.full(N, jnp.cos(t)), **common,
    )  # fmt: skip
    return together, study.Problem(spring.force, 1.0, 0.5, potential=spring.potential, load=jnp.cos, **common)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*WAYS, "central_difference", "houbolt", "wilson_theta", "bathe", "rk4"])
def test_uncoupled_oscillators_are_as_many_single_ones(oscillators, name):
    together, single = oscillators
    alone = np.stack([_phase(single, name, u0=start) for start in together.u0], axis=-1)
    np.testing.assert_allclose(_phase(together, name), alone, rtol=0, atol=1e-12)


LENGTH = 3.0443


@pytest.fixture(scope="module")
def pendulum():
    """A pendulum on an elastic string."""
    energy = study.StrainEnergy(lambda u: (jnp.vdot(u, u) - LENGTH**2)[None], lambda e: 1e3 / (8 * LENGTH**3) * e**2)
    return study.Problem(potential=energy, u0=[LENGTH, 0.0], v0=[0.0, 7.72], mass=10.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scheme",
    ["average_acceleration", "central_difference", "hht_alpha_1996", "bathe", "rk4", "gauss4", "implicit_midpoint",
     "energy_momentum", "average_vector_field"],
)  # fmt: skip
def test_no_direction_is_special(pendulum, scheme):
    """Rotated coordinates rotate the motion of an elastic pendulum."""
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    straight, turned = (
        _phase(pendulum, scheme, dt=0.02, steps=100, u0=t @ pendulum.u0, v0=t @ pendulum.v0) for t in (np.eye(2), turn)
    )
    np.testing.assert_allclose(turned, straight @ turn.T, rtol=0, atol=1e-9)


#: By class, the name of its first scheme that takes massless unknowns.
WITHOUT_MASS = {type(scheme): name for name, scheme in reversed(list(study.schemes.items())) if not scheme.needs_mass}


@pytest.fixture(scope="module")
def springs_in_series():
    """Springs of stiffness 6 and 3 in series, whose joint starts in balance, and one spring of stiffness 2."""
    stiffness, (u0, v0) = np.array([6.0, 3.0]), (0.9, 0.6)
    springs = study.StrainEnergy(_elongations, lambda e: stiffness * e * e / 2)
    series = study.Problem(potential=springs, u0=[u0 / 3, u0], v0=[v0 / 3, v0], mass=[0.0, 2.0])
    return series, study.Problem(lambda u: 2 * u, u0, v0, potential=lambda u: u * u, mass=2.0)


# linear theory shows of every class that it needs no mass; see test_needs_mass.py
SOME = {"bathe", "energy_momentum", "gauss4", "houbolt", "wilson_theta"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in SOME else EXHAUSTIVE) for name in WITHOUT_MASS.values()]
)
def test_a_joint_without_mass_leaves_the_springs_in_series(springs_in_series, name):
    series, single = springs_in_series
    motion = _phase(series, name)
    np.testing.assert_allclose(motion[..., 1], _phase(single, name), rtol=0, atol=1e-9)
    # Wilson's method balances the forces beyond the end of the step
    if name != "wilson_theta":
        np.testing.assert_allclose(motion[0, :, 0], motion[0, :, 1] / 3, rtol=0, atol=1e-9)


def _chain_energy(u):
    return jnp.sum(_hardening(_elongations(u)))


@pytest.mark.parametrize("structure", ["tridiagonal", "matrix_free"])
def test_a_mean_force_of_the_whole_potential_couples_all(structure):
    problem = study.Problem(potential=_chain_energy, u0=np.linspace(0, 1, N), v0=np.zeros(N), tangent=structure)
    with pytest.raises(ValueError, match=r"makes the tangent of 'unnamed problem' full: give it a StrainEnergy"):
        study.run(problem, "energy_momentum", dt=DT, steps=1)


def test_a_mean_force_of_the_whole_potential_keeps_its_energy():
    problem = study.Problem(potential=_chain_energy, u0=np.linspace(0, 1, N), v0=np.zeros(N), tangent="dense")
    ds = study.run(problem, "energy_momentum", dt=0.3, steps=200, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 1e-11
