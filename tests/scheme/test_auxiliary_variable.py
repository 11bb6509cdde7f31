"""BDF2 with a scalar auxiliary variable: linear structures, order, and energy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study

PERIOD = 0.151532834447260357127078726219


def test_a_linear_structure_moves_as_by_bdf2():
    """The motion of a linear structure with damping and a load equals that of BDF2."""
    problem = study.Problem(
        stiffness=np.array([[6.0, -2.0], [-2.0, 4.0]]), mass=np.array([2.0, 1.0]), u0=[1.0, 0.0], v0=[0.0, 1.0],
        damping=study.Rayleigh(a=0.1, b=0.05), load=lambda t: jnp.stack([jnp.cos(t), 0.0 * t]),
    )  # fmt: skip
    auxiliary, bdf2 = (study.run(problem, scheme, dt=0.3, steps=30) for scheme in (study.AuxiliaryVariable(), "bdf2"))
    np.testing.assert_allclose(auxiliary.u, bdf2.u, atol=1e-13)


def test_it_is_of_second_order():
    steps = [400, 800, 1600]
    ends = [
        study.run("hardening", study.AuxiliaryVariable(), dt=PERIOD / 4 / n, steps=n, every=n).u.values[-1]
        for n in steps
    ]
    assert np.log2(np.abs(ends[:-1]) / np.abs(ends[1:])) == pytest.approx(2, abs=0.05)


@pytest.mark.slow
def test_its_energy_does_not_grow_and_its_motion_ends_where_no_forces_balance():
    """The motion ends away from the equilibria −1, 0 and 1 of the double well; the step size is that of the article."""
    problem, scheme, dt = study.problems["double_well"], study.AuxiliaryVariable(), jnp.asarray(2.5)
    state, _ = scheme.start(problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), dt)
    step = jax.jit(lambda state: scheme.step(problem, state, 0.0, dt)[0])
    energies = []
    for _ in range(300):
        state = step(state)
        # this energy does not contain u, because the problem has no stiffness
        energies.append(
            state.v**2 / 2 + (2 * state.v - state.v_1) ** 2 / 2 + state.r**2 + (2 * state.r - state.r_1) ** 2
        )
    assert np.diff(energies).max() < 1e-12 * energies[0]
    assert abs(state.v) < 1e-6 and abs(problem.force(state.u)) > 0.1


def test_a_force_that_has_no_potential_is_refused():
    with pytest.raises(ValueError, match="'SAV-BDF2' needs a force of 'unnamed problem' that is the gradient"):
        study.run(study.Problem(lambda u: u, 1.0), study.AuxiliaryVariable(), dt=0.1, steps=1)
    with pytest.raises(ValueError, match="shift must be a number at least 0"):
        study.AuxiliaryVariable(shift=-1.0)
