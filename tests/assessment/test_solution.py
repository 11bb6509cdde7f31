"""Reference solutions of assessments: their time grid, their interpolation, and the choice of solvers (routes)."""

import warnings

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from reference import piecewise
from study.assessment import certified as certified_module
from study.assessment import reference as reference_module
from study.assessment.certified import certified
from study.assessment.errors import named
from study.assessment.reference import Reference
from study.assessment.solution import DenseSolution
from study.mechanics.loads import excited


@pytest.fixture(scope="module")
def shaken():
    """A damped oscillator on moving ground with a kinked record."""
    ground = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5, 0.0]), 0.3)
    return study.Problem(lambda u: 4 * u + u**3, 0.2, damping=0.1, ground=ground, title="shaken")


def _names(problem, duration):
    return [route.name for route in Reference(problem, duration).routes]


def test_the_interpolant_is_exact_for_polynomials_of_fifth_degree():
    t = np.array([0.0, 0.4, 1.0, 1.7])
    polynomial = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.5, -0.7, 0.2])
    values = [np.stack([p(t), -p(t)], axis=1) for p in (polynomial, polynomial.deriv(), polynomial.deriv(2))]
    times = np.linspace(0, 1.7, 50)
    u, v = DenseSolution(t, *values).at(times)
    np.testing.assert_allclose(u[:, 0], polynomial(times), atol=1e-13)
    np.testing.assert_allclose(v[:, 1], -polynomial.deriv()(times), atol=1e-12)


@pytest.mark.slow
def test_a_load_that_acts_for_a_moment_is_not_stepped_over():
    """A solver whose steps pass over a load that acts for a millisecond."""
    # an impulse of one newton second within a millisecond on an oscillator in free motion
    start, length = 10.003, 1e-3
    blow = study.Problem(
        lambda u: u, 0.1, load=lambda t: jnp.where((t > start) & (t < start + length), 1 / length, 0.0), title="blow"
    )
    reference = Reference(blow, 20.0)
    np.testing.assert_allclose(reference.kinks.force, [start, start + length], rtol=1e-12)
    grid = reference.grid(1.0)
    exact = 0.1 * np.cos(20.0) + (np.cos(20.0 - start - length) - np.cos(20.0 - start)) / length
    for route in reference.routes:
        assert reference.solution(route, grid, 1e-10).u[-1] == pytest.approx(exact, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("shape, lasts", [("rectangle", 1e-3), ("table", 1e-5), ("smooth", 1e-5)])
def test_the_certified_reference_contains_a_short_pulse(shape, lasts):
    """The impulse of one newton second at t = 3.3 on an oscillator that moves already; the peak is that of a blow."""
    table = 3.3 + lasts * np.array([-1.0, 0.0, 0.5, 1.0, 2.0]), np.array([0.0, 0.0, 2.0, 0.0, 0.0]) / lasts
    load = {
        "rectangle": lambda t: jnp.where((t >= 3.3) & (t < 3.3 + lasts), 1 / lasts, 0.0),
        "table": lambda t: jnp.interp(t, *table),
        "smooth": lambda t: jnp.exp(-(((t - 3.3) / lasts) ** 2)) / lasts / np.sqrt(np.pi),
    }[shape]
    omega, ratio = 2 * np.pi, 0.02
    damped = omega * np.sqrt(1 - ratio**2)
    struck = study.Problem(lambda u: omega**2 * u, 0.01, damping=2 * ratio * omega, load=load, title="struck")
    t = np.linspace(3.31, 5.0, 20_001)
    free = 0.01 * np.exp(-ratio * omega * t) * (np.cos(damped * t) + ratio * omega / damped * np.sin(damped * t))
    blow = np.exp(-ratio * omega * (t - 3.3)) * np.sin(damped * (t - 3.3)) / damped
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the shortest pulses are announced
        # as in an assessment, the load is scaled
        reference = certified(
            excited(struck, 1.0, displaced=True), 5.0, named({"u": study.Quantity(lambda u: u)}), 1e-2, 0.25, False
        )
    assert reference.horizon == 5.0
    u, _ = reference.solution.at(t)
    np.testing.assert_allclose(u, free + blow, atol=0.15 * (1.5 * lasts * omega + 1e-4))


def test_a_pulse_that_is_shorter_than_the_scan_can_find_is_announced():
    def load(t):
        return jnp.where((t > 3.3) & (t < 3.30001), 1e5, 0.0)

    brief = Reference(study.Problem(lambda u: u, 0.1, load=load, title="brief"), 5.0)
    with pytest.warns(RuntimeWarning, match="'brief' has a pulse of about 1e-05 s; another one shorter than 8e-05 s"):
        certified_module._check_shortest(brief)


def test_solvers_that_part_at_a_pulse_give_no_reference(monkeypatch):
    """The scan is switched off, so that only one of the solvers meets a pulse."""
    monkeypatch.setattr(reference_module, "times_of_problem", lambda *_: np.zeros(0))
    monkeypatch.setattr(certified_module, "times_of", lambda *_: np.zeros(0))
    times = np.array([5.0, 5.001, 5.002])
    struck = study.Problem(
        lambda u: 39.5 * u, 0.01, load=lambda t: jnp.interp(t, times, times * 0 + [0, 1e3, 0]), title="hit"
    )
    with pytest.raises(reference_module.NoReference, match="give the load an attribute kinks with the times"):
        certified(struck, 8.0, named({"u": study.Quantity(lambda u: u)}), 1e-2, 0.25, False)


def test_the_grid_holds_all_kinks_and_no_point_next_to_one(shaken):
    grid = Reference(shaken, 2.0).grid(0.5)
    assert np.isin([0.0, 0.3, 0.6, 0.9, 1.2, 2.0], np.round(grid, 12)).all()
    assert np.diff(grid).min() > 0.05 * np.diff(grid).max()


@pytest.mark.slow
def test_both_routes_solve_a_kinked_load(shaken):
    reference = Reference(shaken, 2.0)
    assert _names(shaken, 2.0) == ["diffrax Dopri8", "CVODE Adams"]
    times = np.arange(9) * 0.3

    def rate(t, y):
        return [y[1], -0.1 * y[1] - 4 * y[0] - y[0] ** 3 - np.interp(t, times[:5], [0, 1, -2, 0.5, 0], right=0)]

    pieces, state = [np.array([0.2, 0.0])], [0.2, 0.0]
    for start, end in zip([0, 0.3, 0.6, 0.9, 1.2], [0.3, 0.6, 0.9, 1.2, 2.0], strict=True):
        state = solve_ivp(rate, (start, end), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        pieces.append(state)
    for route in reference.routes:
        solution = reference.solution(route, reference.grid(0.5), 1e-10)
        u, v = solution.at(np.array([0, 0.3, 0.6, 0.9, 1.2, 2.0]))
        np.testing.assert_allclose(np.stack([u, v], axis=1), pieces, atol=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [1e2, 1e6])
def test_contacts_are_stepped_on_and_interpolated_between(stiffness):
    """Both routes meet the exact motion, which is harmonic during contact with the stop and without contact."""
    omega, opening, duration = 2 * np.pi, 0.5, 3.0
    stop = study.materials.gap(stiffness=stiffness, opening=opening)
    problem = study.Problem(lambda u: omega**2 * u + stop(u), 0.0, 5.0, title="stop")
    reference = Reference(problem, duration)

    contact = np.sqrt(omega**2 + stiffness)
    centre = stiffness * opening / contact**2  # equilibrium of the oscillation in contact
    speed = np.sqrt(25 - (omega * opening) ** 2)
    reach = np.hypot(opening - centre, speed / contact)
    touch = np.arcsin(opening * omega / 5) / omega
    lasts = 2 * np.arccos((opening - centre) / reach) / contact
    period = 2 * touch + np.pi / omega + lasts  # the half-wave on the side without a stop takes π/ω
    times = touch + period * np.arange(5)
    exact = np.sort(np.concatenate([times, times + lasts]))
    exact = exact[exact < duration]
    np.testing.assert_allclose(reference.kinks.force, exact, atol=1e-9)

    deepest = times[times + lasts < duration] + lasts / 2
    inside = times[times + lasts < duration] + 0.3 * lasts
    for route in reference.routes:
        solution = reference.solution(route, reference.grid(1.0), 1e-12)
        np.testing.assert_allclose(solution.at(deepest)[0], centre + reach, atol=1e-8)
        np.testing.assert_allclose(solution.at(inside)[0], centre + reach * np.cos(0.2 * lasts * contact), atol=1e-8)


def test_heyoka_takes_a_free_oscillator_and_a_table_sends_it_away():
    free = study.Problem(jnp.sin, u0=1.0)
    assert _names(free, 10.0) == ["heyoka", "CVODE Adams"]
    table = study.Problem(lambda u: jnp.interp(u, jnp.array([-2.0, 0.0, 2.0]), jnp.array([-3.0, 0.0, 2.0])), u0=1.0)
    assert _names(table, 10.0) == ["diffrax Dopri8", "CVODE Adams"]


def test_stiff_problems_take_implicit_routes():
    assert _names(study.problems["stiff_soft"], 1e4) == ["diffrax Kvaerno5", "CVODE BDF"]


@pytest.mark.slow
def test_a_force_with_a_velocity_is_solved_by_diffrax():
    """A force with a velocity that goes to heyoka, which cannot translate it, or loses its velocity on the way."""
    drag = study.Problem(lambda u, v: 40 * u + 2 * v**3, 0.5, title="drag")
    assert _names(drag, 2.0) == ["diffrax Dopri8", "CVODE Adams"]
    reference, t = Reference(drag, 2.0), np.linspace(0, 2, 21)
    first, second = (reference.solution(route, t, 1e-10) for route in reference.routes)
    np.testing.assert_allclose(first.u, second.u, atol=1e-7)


def _under_record(spring):
    load = study.GroundMotion(3 * np.sin(1.7 * np.arange(40)), 0.1)
    return study.Problem(spring, 0.0, 1.0, damping=0.2, ground=load, title="with a history")


@pytest.mark.slow
def test_both_routes_reach_the_exact_motion_of_a_spring_that_yields():
    problem = _under_record(study.materials.elastoplastic(stiffness=40.0, yield_force=2.0, hardening=0.1))
    reference = Reference(problem, 4.0)
    t = reference.grid(1.0)
    exact = piecewise.trajectory(problem, t[1:])
    assert _names(problem, 4.0) == ["diffrax Dopri8", "CVODE Adams"] and len(reference.kinks.force) > 5
    for route in reference.routes:
        solution = reference.solution(route, t, 1e-12)
        np.testing.assert_allclose(solution.u[1:], exact.u, atol=1e-10)
        np.testing.assert_allclose(solution.v[1:], exact.v, atol=1e-9)
        np.testing.assert_allclose(np.gradient(solution.v, t)[50], solution.a[50], rtol=0.02)


@pytest.mark.slow
def test_both_routes_follow_elements_that_turn_back_apart_from_each_other():
    """Both routes agree with SciPy's solution of Bouc and Wen's rate equation, which needs no committed history."""
    k, bound = np.array([40.0, 25.0]), np.array([0.05, 0.04])
    springs = study.materials.elements(
        study.materials.bouc_wen(stiffness=k, yield_force=k * bound), lambda u: jnp.diff(u, prepend=0.0), 2
    )
    problem = study.Problem(springs, np.zeros(2), np.array([1.0, -0.5]), title="two springs")

    def rate(t, y):
        _, v, z = y.reshape(3, 2)
        force, speed = k * bound * z, np.diff(v, prepend=0.0)
        return np.concatenate([v, np.append(force[1], 0) - force, speed / bound * (1 - np.abs(z) * (z * speed > 0))])

    reference = Reference(problem, 3.0)
    t = reference.grid(1.0)
    exact = solve_ivp(rate, (0, 3), [0, 0, 1, -0.5, 0, 0], method="LSODA", t_eval=t, rtol=1e-11, atol=1e-13).y[:2].T
    for route in reference.routes:
        np.testing.assert_allclose(reference.solution(route, t, 1e-12).u, exact, atol=1e-7)
