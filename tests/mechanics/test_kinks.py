"""Newton's iteration for forces with jumps of the slope, compared with a bracketing root finder."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import study
from study.mechanics.balance import balance
from study.mechanics.newton import MAX_ITERATIONS

slopes = st.lists(st.floats(0.0, 1e4), min_size=4, max_size=4)
kinks = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3)


class PieceByPiece(eqx.Module):
    """A continuous force that is linear between kinks, with a given slope of at least zero in each interval."""

    slopes: np.ndarray
    kinks: np.ndarray

    def __call__(self, u):
        pieces = jnp.maximum(u - self.kinks, 0.0)
        return self.slopes[0] * u + jnp.sum(jnp.diff(self.slopes) * pieces)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(slopes=slopes, kinks=kinks, rhs=st.floats(-100.0, 100.0), u=st.floats(-2.0, 2.0), c_u=st.floats(1e-4, 1.0))
def test_random_pieces_are_solved_as_by_bisection(slopes, kinks, rhs, u, c_u):
    """A force with kinks on which Newton runs in a cycle, or finds a wrong root."""
    force = PieceByPiece(np.array(slopes), np.sort(np.array(kinks)))
    problem = study.Problem(force, u0=0.0)
    assert problem.kinked
    a, effort = eqx.filter_jit(balance)(problem, *map(jnp.asarray, (rhs, u, 0.0, c_u, 0.5, 0.0)))
    root = brentq(lambda x: x + float(force(u + c_u * x)) - rhs, -1e7, 1e7, xtol=1e-13, rtol=1e-14)
    assert effort.converged
    assert float(u + c_u * a) == pytest.approx(u + c_u * root, rel=1e-9, abs=1e-9)


def test_two_branches_do_not_take_turns():
    """The balance is found in a few iterations, although plain Newton iteration cycles between the outer branches."""
    force = PieceByPiece(np.array([1.0, 100.0, 1.0]), np.array([-1.0, 1.0]))
    plain = 3.0
    for _ in range(20):
        plain -= (float(force(plain)) - 99.0) / (1.0 if abs(plain) > 1 else 100.0)
    assert abs(plain) > 90
    problem = study.Problem(force, u0=0.0, mass=1e-6)
    a, effort = eqx.filter_jit(balance)(problem, *map(jnp.asarray, (99.0, 0.0, 0.0, 1.0, 0.5, 3.0)))
    assert effort.converged and float(a) == pytest.approx(0.0, abs=1e-6)
    assert effort.iterations < 10


def test_a_force_that_jumps_is_met_in_the_jump():
    """If the mass stops within the step, the root of the balance lies in the jump of Coulomb's law."""
    problem = study.Problem(lambda u, v: 5.0 * jnp.sign(v), u0=0.0, v0=0.1)
    a, effort = eqx.filter_jit(balance)(problem, *map(jnp.asarray, (0.0, 0.05, 0.1, 0.25, 0.5, -5.0)))
    assert effort.converged and effort.iterations < MAX_ITERATIONS
    assert float(0.1 + 0.5 * a) == pytest.approx(0.0, abs=1e-12)


class RowWithStops(eqx.Module):
    """Force on four masses in a row of springs; the stop at each mass is a hundred times as stiff as a spring."""

    openings: np.ndarray

    def __call__(self, u):
        stretch = jnp.diff(u, prepend=0.0)
        return stretch - jnp.append(stretch[1:], 0.0) + 100.0 * jnp.maximum(u - self.openings, 0.0)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_several_unknowns_with_stops_are_solved(seed):
    random = np.random.default_rng(seed)
    force = RowWithStops(random.uniform(-0.2, 0.2, 4))
    problem = study.Problem(force, u0=np.zeros(4), tangent="dense")
    rhs, u = random.uniform(-5, 5, (2, 4)) * [[1.0], [0.1]]
    arguments = [jnp.asarray(x) for x in (rhs, u, np.zeros(4), 1.0, 0.5, np.zeros(4))]
    a, effort = eqx.filter_jit(balance)(problem, *arguments)
    assert effort.converged
    assert np.asarray(a + force(u + a) - rhs) == pytest.approx(np.zeros(4), abs=1e-8)


def _softened(u):
    """A force whose stiffness falls to a hundredth beyond |u| = 0.1."""
    return 1e4 * (u - 0.99 * jnp.where(u > 0.1, u - 0.1, 0.0) - 0.99 * jnp.where(u < -0.1, u + 0.1, 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("v0", [[5.0], [5.0, 3.0], [5.0, 3.0, 2.0, 1.0]])
@pytest.mark.parametrize("dt", [0.05, 0.1])
def test_uncoupled_springs_that_soften_run_as_each_of_them_alone(v0, dt):
    together = study.run(
        study.Problem(_softened, np.zeros(len(v0)), v0), "average_acceleration", dt=dt, steps=100, on_failure="raise"
    )
    alone = study.run(study.Problem(_softened, 0.0, v0[0]), "average_acceleration", dt=dt, steps=100)
    # compared over 20 steps; later, round-off makes the runs diverge, because the step is too long for the spring
    np.testing.assert_allclose(together.u[:20, 0], alone.u[:20], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("hardening", [0.0, 0.05])
def test_a_yielding_frame_runs_with_coarse_steps(hardening):
    storeys = study.materials.elements(
        study.materials.elastoplastic(stiffness=1e4, yield_force=100.0, hardening=hardening),
        lambda u: jnp.diff(u, prepend=0.0),
        5,
    )
    ground = study.GroundMotion.el_centro().scaled(3.0)
    frame = study.Problem(storeys, np.zeros(5), ground=ground)
    ds = study.run(frame, "average_acceleration", dt=0.1, steps=200, observe=["newton_iterations"], on_failure="raise")
    assert int(ds.max_newton_iterations) < MAX_ITERATIONS


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [0.1, 0.25])
def test_fluid_dampers_of_small_exponent_run(exponent):
    dampers = study.materials.elements(
        study.materials.viscous_damper(coefficient=5.0, exponent=exponent), lambda u: u, 2
    )
    problem = study.Problem(lambda u, v: 40.0 * u + dampers(u, v), np.zeros(2), ground=study.GroundMotion.el_centro())
    study.run(problem, "average_acceleration", dt=0.02, steps=300, on_failure="raise")


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e9])
def test_several_unknowns_do_not_swing_between_sticking_and_slipping(stiffness):
    """The balance with a contact far stiffer than its neighbours minimises a convex function, and is always found."""
    contact = study.materials.elements(
        study.materials.friction(slip_force=20.0, stiffness=stiffness), lambda u: u[:-1] - u[1:], 1
    )

    def force(u, v, history):
        q, history = contact(u, v, history)
        return q + jnp.array([50.0, 100.0]) * u, history

    problem = study.Problem(force, u0=np.zeros(2), history=contact.history, tangent="dense")
    v0 = 3 * np.random.default_rng(0).normal(size=(40, 2))
    ds = study.run(problem, "average_acceleration", dt=0.3, steps=300, v0=v0)
    assert not ds.status.any()
