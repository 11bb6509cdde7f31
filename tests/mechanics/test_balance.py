"""The balance of forces, compared with an independent root finder and with dense NumPy matrices."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import brentq

import study
from study.mechanics.balance import acceleration, balance, initial_acceleration

finite = st.floats(-3.0, 3.0)


def _cubic(coefficient, x):
    return x + coefficient * x**3


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(u=finite, v=finite, rhs=finite, c_u=st.floats(1e-6, 1.0), weight=st.floats(0.5, 1.0), cubic=st.floats(0.0, 10.0))
def test_newton_finds_the_root(u, v, rhs, c_u, weight, cubic):
    problem = study.Problem(eqx.Partial(_cubic, np.float64(cubic)), u0=0.0, mass=2.0, damping=0.3)
    # arrays, because every value of a Python number would be compiled into a new program
    numbers = [jnp.asarray(number) for number in (rhs, u, v, c_u, 0.5, 0.0, weight)]
    a, effort = eqx.filter_jit(balance)(problem, *numbers)

    def residual(x):
        return 2 * x + 0.3 * (v + 0.5 * x) + weight * float(problem.force(u + c_u * x)) - rhs

    root = brentq(residual, -1e4, 1e4, xtol=1e-14, rtol=1e-14)
    assert effort.converged
    assert float(a) == pytest.approx(root, rel=1e-9, abs=1e-9)


def _stiffening(stiffness, u):
    return stiffness @ u + u**3


@pytest.mark.slow
@pytest.mark.parametrize(
    "mass",
    [None, 2.0, np.array([2.0, 1.0]), np.array([[2.0, 0.3], [0.3, 1.0]])],
    ids=["none", "number", "diagonal", "matrix"],
)
@pytest.mark.parametrize(
    "damping",
    [None, 0.5, np.array([0.5, 0.1]), np.array([[0.5, -0.1], [-0.1, 0.4]])],
    ids=["none", "number", "diagonal", "matrix"],
)
def test_every_form_of_mass_and_damping(mass, damping):
    """M a + C (v + c_v a) + p(u + c_u a) = r, checked with dense NumPy matrices."""
    stiffness = np.array([[6.0, -2.0], [-2.0, 4.0]])
    problem = study.Problem(
        eqx.Partial(_stiffening, stiffness), u0=np.zeros(2), v0=np.zeros(2), mass=mass, damping=damping
    )
    u, v, rhs = np.array([0.3, -0.2]), np.array([1.0, 2.0]), np.array([0.5, 10.0])
    numbers = [jnp.asarray(number) for number in (rhs, u, v, 0.1, 0.4, np.zeros(2))]
    solution, effort = eqx.filter_jit(balance)(problem, *numbers)
    M, C = (_dense(x, default) for x, default in ((mass, 1.0), (damping, 0.0)))
    a = np.asarray(solution)
    x = u + 0.1 * a
    assert effort.converged
    np.testing.assert_allclose(M @ a + C @ (v + 0.4 * a) + stiffness @ x + x**3, rhs, atol=1e-12)

    a = np.asarray(eqx.filter_jit(acceleration)(problem, 0.0, jnp.asarray(u), jnp.asarray(v), 0.4))
    np.testing.assert_allclose(M @ a + C @ (v + 0.4 * a) + stiffness @ u + u**3, 0.0, atol=1e-12)


def _along(u):
    return jnp.stack([u[0], u[1] - u[0], u[2] - u[1]])


def _linear_springs(moduli, e):
    return moduli * e * e


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [1e3, 1e7, 1e9, 1e11])
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "energy_momentum", "gauss4"])
def test_stiff_links_are_no_failure_of_newton(scheme, stiffness):
    """Runs succeed although the force in a stiff link has the round-off of the displacement times the stiffness."""
    moduli = np.array([0.5, 0.5 * stiffness, 0.5 * stiffness])
    # the moduli are arguments of the energy, so that all stiffnesses share one program
    energy = study.StrainEnergy(_along, eqx.Partial(_linear_springs, moduli))
    ds = study.run(study.Problem(potential=energy, u0=np.ones(3)), scheme, dt=0.1, steps=50)
    assert ds.status == 0
    # the stiff links join the three masses to one, which oscillates on the soft spring
    np.testing.assert_allclose(ds.u[:, 0], np.cos(ds.t / np.sqrt(3)), atol=2e-2)


def _dense(x, default):
    x = np.asarray(default if x is None else x)
    return x if x.ndim == 2 else np.diag(np.broadcast_to(x, 2))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "gauss4", "energy_momentum"])
def test_steps_are_vectorised_and_differentiated_twice(name):
    """Derivatives of steps equal differences. Vectorised steps and first derivatives also work without compilation.

    The Lyapunov exponent needs the first derivatives.
    """
    scheme, problem, dt = study.schemes[name], study.problems["hardening"], jnp.asarray(0.01)

    def moved(u0):
        state, _ = scheme.start(problem, u0, jnp.asarray(0.3), dt)
        for _ in range(2):
            state, _ = scheme.step(problem, state, jnp.asarray(0.0), dt)
        return state.u

    u0, h = jnp.asarray([1.0, 1.2]), 1e-4
    np.testing.assert_allclose(jax.vmap(moved)(u0), [moved(start) for start in u0], rtol=1e-14)
    first, second = jax.jacfwd(moved), jax.jacfwd(jax.jacfwd(moved))
    values, slopes, bends = (jax.jit(jax.vmap(function)) for function in (moved, first, second))
    slope, bend = slopes(u0), bends(u0)
    before, middle, after = (values(u0 + way * h) for way in (-1, 0, 1))
    np.testing.assert_allclose(first(u0[0]), slope[0], rtol=1e-12)
    np.testing.assert_allclose(slope, (after - before) / (2 * h), rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(bend, (after - 2 * middle + before) / h**2, rtol=1e-5)


@pytest.mark.parametrize("form", ["diagonal", "dense", "sparse"])
def test_the_initial_acceleration_of_an_unknown_without_mass_is_zero(form):
    """A = (f − p)/m elsewhere, also for masses below one."""
    mass, u = np.array([0.5, 0.0, 2.0]), np.array([1.0, 2.0, 3.0])
    matrix = {"diagonal": mass, "dense": np.diag(mass), "sparse": sparse.diags_array(mass, format="csc")}[form]
    stiffness = sparse.eye_array(3, format="csc") if form == "sparse" else None
    problem = study.Problem(
        None if form == "sparse" else lambda u: u, u, mass=matrix, stiffness=stiffness, load=lambda t: jnp.full(3, 4.0)
    )
    a = initial_acceleration(problem, problem.u0, problem.v0)
    np.testing.assert_allclose(a, [(4 - 1) / 0.5, 0.0, (4 - 3) / 2], rtol=1e-14)
