"""Symplectic and symmetric maps."""

import jax
import jax.numpy as jnp
import pytest

import study


@pytest.mark.slow
@pytest.mark.parametrize("name", ["implicit_midpoint", "gauss4", "symplectic_euler", "mclachlan4", "yoshida4",
                                  "yoshida6", "kahan_li8", "blanes_moan4", "velocity_verlet"])  # fmt: skip
def test_symplectic_maps_keep_areas(name):
    """The derivative of a step on a non-linear spring with respect to (u, u̇) has the determinant one."""
    problem, scheme, dt = study.problems["softening"], study.schemes[name], jnp.asarray(0.05)

    def step(phase):
        state, _ = scheme.start(problem, phase[0], phase[1], dt)
        state, _ = scheme.step(problem, state, 0.0, dt)
        return jnp.stack([state.u, state.v])

    for phase in ([0.3, 2.0], [-1.0, 5.0]):
        assert jnp.linalg.det(jax.jacfwd(step)(jnp.asarray(phase))) == pytest.approx(1, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "implicit_midpoint", "energy_momentum", "gauss4",
                                  "average_vector_field", "mclachlan4", "yoshida4", "yoshida6", "kahan_li8",
                                  "blanes_moan4", "velocity_verlet"])  # fmt: skip
def test_symmetric_schemes_come_back(name):
    problem = study.problems["softening"]
    end = study.run(problem, name, dt=0.05, steps=40).isel(t=-1)
    back = study.Problem(problem.force, float(end.u), -float(end.v), potential=problem.potential)
    returned = study.run(back, name, dt=0.05, steps=40).isel(t=-1)
    assert returned.u.item() == pytest.approx(4.0, abs=1e-10)
    assert returned.v.item() == pytest.approx(0.0, abs=1e-9)
