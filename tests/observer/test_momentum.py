"""Linear and angular momentum."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem import trusses


@pytest.mark.slow
def test_conservation_in_a_spinning_truss(small_truss):
    """The energy-momentum method conserves the energy and both momenta, the midpoint rule only the momenta.

    Only this test catches wrong momenta of many masses with a tangent in bands.
    """
    problem = trusses.spinning_truss()
    conserving, midpoint = (
        study.run(problem, name, dt=0.1, steps=100, observe=["max_energy_error", "momentum_errors"])
        for name in ("energy_momentum", "implicit_midpoint")
    )
    for ds in (conserving, midpoint):
        assert ds.status == 0
        assert ds.max_linear_momentum_error < 1e-10 and ds.max_angular_momentum_error < 1e-10
    assert conserving.max_energy_error < 1e-10 < 1e-5 < midpoint.max_energy_error


def test_momenta_in_space_are_those_in_the_plane():
    """Two masses on a spring, in a plane and rotated in space; Houbolt's method does not conserve angular momentum.

    Only this test catches a wrong angular momentum in space.
    """
    places, speeds = np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array([[0.3, -1.0], [0.1, 1.0]])
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0][:, :2].T

    def observed(places, speeds, scheme):
        def strains(u):
            first, second = places + u.reshape(places.shape)
            return (jnp.linalg.norm(second - first) - 2)[None]

        energy = study.StrainEnergy(strains, lambda e: 5 * e * e)
        pair = study.Problem(potential=energy, u0=np.zeros(places.size), v0=speeds.ravel(), positions=places)
        return study.run(pair, scheme, dt=0.1, steps=50, observe=["momentum_errors"])

    plane, space = observed(places, speeds, "houbolt"), observed(places @ turn, speeds @ turn, "houbolt")
    for name in ("max_linear_momentum_error", "max_angular_momentum_error"):
        assert space[name].item() == pytest.approx(plane[name].item(), abs=1e-12)
    assert plane.max_linear_momentum_error < 1e-12 and plane.max_angular_momentum_error > 1e-3
    assert observed(places @ turn, speeds @ turn, "energy_momentum").max_angular_momentum_error < 1e-12


def test_momenta_need_the_positions_of_the_masses():
    with pytest.raises(ValueError, match="of 'tried' needs Problem\\(positions=...\\), which it was made without."):
        problem = study.Problem(jnp.sinh, np.zeros(5), title="tried")
        study.run(problem, "rk4", dt=0.1, steps=1, observe=["momentum_errors"])
