"""Trigonometric methods: exact linear parts, and second order between resonances."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem.chains import fpu_chain
from study.scheme.trigonometric import filters

CHAIN = fpu_chain(separate=True)


@pytest.fixture(scope="module")
def reference():
    """Displacement of the chain at t = 1, by 2000 steps of the Runge-Kutta method."""
    return study.run(CHAIN, "rk4", dt=1 / 2000, steps=2000, every=2000).u.values[-1]


@pytest.mark.slow
@pytest.mark.parametrize("member", filters)
def test_a_linear_problem_is_solved_exactly(member):
    problem = study.Problem(stiffness=np.array([9.0, 400.0]), mass=np.array([1.0, 2.0]), u0=[1.0, 0.5], v0=[0.0, 2.0])
    ds = study.run(problem, study.Trigonometric(member=member), dt=0.7, steps=10)
    omega, t = np.sqrt([9.0, 200.0]), ds.t.values[:, None]
    exact = np.array([1.0, 0.5]) * np.cos(omega * t) + np.array([0.0, 2.0]) / omega * np.sin(omega * t)
    np.testing.assert_allclose(ds.u, exact, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("member", filters)
def test_without_a_stiffness_it_is_velocity_verlet(member):
    trigonometric, verlet = (
        study.run("softening", scheme, dt=0.05, steps=50)
        for scheme in (study.Trigonometric(member=member), "velocity_verlet")
    )
    np.testing.assert_allclose(trigonometric.u, verlet.u, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("member", filters)
def test_the_error_is_of_second_order_beyond_the_limit_of_verlet_and_below_the_resonances(member, reference):
    """The error is below 1.5 Δt² up to ωΔt = 2.5, ω = 50. Velocity Verlet, stable up to 2, errs by 60 to 120 Δt²."""
    steps = np.array([20, 40, 80, 160])
    ends = [
        study.run(CHAIN, study.Trigonometric(member=member), dt=1 / n, steps=n, every=n).u.values[-1] for n in steps
    ]
    constants = np.abs(np.array(ends) - reference).max(axis=1) * steps**2
    assert (constants < 1.5).all()
    assert np.log2(constants[-2] / constants[-1]) == pytest.approx(0, abs=0.1)


def test_the_chain_is_the_same_with_its_stiff_springs_apart(reference):
    together = study.run("fpu_chain", "rk4", dt=1 / 2000, steps=2000, every=2000)
    np.testing.assert_allclose(reference, together.u.values[-1], atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("member, symplectic", [("deuflhard", True), ("garcia_archilla", True), ("gautschi", False)])
def test_two_members_are_symplectic(member, symplectic):
    """If a method is symplectic, the derivative D of its step with respect to (u, u̇) keeps the form J: DᵀJD = J."""
    problem = study.Problem(
        potential=lambda u: (u[0] - u[1]) ** 4 / 4, u0=[0.9, -0.3], v0=[0.0, 2.0], stiffness=np.array([25.0, 4.0])
    )
    scheme, dt = study.Trigonometric(member=member), jnp.asarray(0.4)

    def step(phase):
        state, _ = scheme.start(problem, phase[:2], phase[2:], dt)
        state, _ = scheme.step(problem, state, 0.0, dt)
        return jnp.concatenate([state.u, state.v])

    slope = jax.jacfwd(step)(jnp.asarray([0.9, -0.3, 0.0, 2.0]))
    form = np.kron([[0, 1], [-1, 0]], np.eye(2))
    assert (np.abs(slope.T @ form @ slope - form).max() < 1e-12) == symplectic


def test_what_it_does_not_fit_is_refused():
    damped = study.Problem(lambda u: u**3, 1.0, stiffness=25.0, damping=0.1)
    coupled = study.Problem(stiffness=np.array([[2.0, -1.0], [-1.0, 2.0]]), u0=[1.0, 0.0])
    for problem in (damped, coupled):
        with pytest.raises(ValueError, match="'Trigonometric' solves the linear part of 'unnamed problem' exactly"):
            study.run(problem, study.Trigonometric(member="gautschi"), dt=0.1, steps=1)
    with pytest.raises(ValueError, match="did you mean 'deuflhard'"):
        study.Trigonometric(member="deufelhard")
