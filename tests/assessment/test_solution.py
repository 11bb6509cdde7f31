"""The solution by a route: the grid, the interpolation, the choice of routes."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from study.assessment import solution


@pytest.fixture(scope="module")
def shaken():
    """A damped oscillator on moving ground with a kinked record."""
    ground = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.5, 0.0]), 0.3)
    return study.Problem(lambda u: 4 * u + u**3, 0.2, damping=0.1, ground=ground, title="shaken")


def _routes(problem, duration):
    return solution.routes_of(problem, duration, solution.kinks_of(problem, duration))


def test_the_interpolant_is_exact_for_polynomials_of_fifth_degree():
    t = np.array([0.0, 0.4, 1.0, 1.7])
    polynomial = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.5, -0.7, 0.2])
    values = [np.stack([p(t), -p(t)], axis=1) for p in (polynomial, polynomial.deriv(), polynomial.deriv(2))]
    at = np.linspace(0, 1.7, 50)
    u, v = solution.DenseSolution(t, *values).at(at)
    np.testing.assert_allclose(u[:, 0], polynomial(at), atol=1e-13)
    np.testing.assert_allclose(v[:, 1], -polynomial.deriv()(at), atol=1e-12)


def test_a_load_that_acts_for_a_moment_is_not_stepped_over():
    # a blow of one newton second in a millisecond on an oscillator in free motion
    begins, lasts = 10.003, 1e-3
    blow = study.Problem(
        lambda u: u, 0.1, load=lambda t: jnp.where((t > begins) & (t < begins + lasts), 1 / lasts, 0.0), title="blow"
    )
    kinks = solution.kinks_of(blow, 20.0)
    np.testing.assert_allclose(kinks.of_force, [begins, begins + lasts], rtol=1e-12)
    grid = solution.grid_of(blow, 20.0, 1.0, kinks)
    exact = 0.1 * np.cos(20.0) + (np.cos(20.0 - begins - lasts) - np.cos(20.0 - begins)) / lasts
    for route in solution.routes_of(blow, 20.0, kinks):
        assert solution.solution_by(route, blow, grid, 1e-10).u[-1] == pytest.approx(exact, abs=1e-7)


def test_the_grid_holds_all_kinks_and_no_point_next_to_one(shaken):
    grid = solution.grid_of(shaken, 2.0, 0.5, solution.kinks_of(shaken, 2.0))
    assert np.isin([0.0, 0.3, 0.6, 0.9, 1.2, 2.0], np.round(grid, 12)).all()
    assert np.diff(grid).min() > 0.05 * np.diff(grid).max()


def test_both_routes_solve_a_kinked_load(shaken):
    kinks = solution.kinks_of(shaken, 2.0)
    grid = solution.grid_of(shaken, 2.0, 0.5, kinks)
    routes = solution.routes_of(shaken, 2.0, kinks)
    assert [route.name for route in routes] == ["diffrax Dopri8", "CVODE Adams"]
    times = np.arange(9) * 0.3

    def rate(t, y):
        return [y[1], -0.1 * y[1] - 4 * y[0] - y[0] ** 3 - np.interp(t, times[:5], [0, 1, -2, 0.5, 0], right=0)]

    pieces, state = [np.array([0.2, 0.0])], [0.2, 0.0]
    for start, end in zip([0, 0.3, 0.6, 0.9, 1.2], [0.3, 0.6, 0.9, 1.2, 2.0], strict=True):
        state = solve_ivp(rate, (start, end), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        pieces.append(state)
    for route in routes:
        one = solution.solution_by(route, shaken, grid, 1e-10)
        u, v = one.at(np.array([0, 0.3, 0.6, 0.9, 1.2, 2.0]))
        np.testing.assert_allclose(np.stack([u, v], axis=1), pieces, atol=1e-8)


@pytest.mark.parametrize("stiffness", [1e2, 1e6])
def test_contacts_are_stepped_on_and_interpolated_between(stiffness):
    """Every half-wave in free flight and every one in contact with the stop is a sine."""
    omega, opening, duration = 2 * np.pi, 0.5, 3.0
    stop = study.materials.gap(stiffness, opening=opening)
    problem = study.Problem(lambda u: omega**2 * u + stop(u), 0.0, 5.0, title="stop")
    kinks = solution.kinks_of(problem, duration)
    grid = solution.grid_of(problem, duration, 1.0, kinks)

    contact = np.sqrt(omega**2 + stiffness)
    centre = stiffness * opening / contact**2  # about which it swings in contact
    speed = np.sqrt(25 - (omega * opening) ** 2)
    reach = np.hypot(opening - centre, speed / contact)
    touch = np.arcsin(opening * omega / 5) / omega
    lasts = 2 * np.arccos((opening - centre) / reach) / contact
    period = 2 * touch + np.pi / omega + lasts  # half a swing away from the stop, and back
    times = touch + period * np.arange(5)
    exact = np.sort(np.concatenate([times, times + lasts]))
    exact = exact[exact < duration]
    np.testing.assert_allclose(kinks.of_force, exact, atol=1e-9)

    deepest = times[times + lasts < duration] + lasts / 2
    inside = times[times + lasts < duration] + 0.3 * lasts
    for route in solution.routes_of(problem, duration, kinks):
        one = solution.solution_by(route, problem, grid, 1e-12)
        np.testing.assert_allclose(one.at(deepest)[0], centre + reach, atol=1e-8)
        np.testing.assert_allclose(one.at(inside)[0], centre + reach * np.cos(0.2 * lasts * contact), atol=1e-8)


def test_heyoka_takes_a_free_oscillator_and_a_table_sends_it_away():
    free = study.Problem(jnp.sin, u0=1.0)
    assert [route.name for route in _routes(free, 10.0)] == ["heyoka", "diffrax Dopri8"]
    table = study.Problem(lambda u: jnp.interp(u, jnp.array([-2.0, 0.0, 2.0]), jnp.array([-3.0, 0.0, 2.0])), u0=1.0)
    assert [route.name for route in _routes(table, 10.0)] == ["diffrax Dopri8", "CVODE Adams"]


def test_stiff_problems_take_implicit_routes():
    routes = _routes(study.problems["stiff_soft"], 1e4)
    assert [route.name for route in routes] == ["diffrax Kvaerno5", "CVODE BDF"]


def test_a_force_with_a_velocity_is_solved_by_diffrax():
    drag = study.Problem(lambda u, v: 40 * u + 2 * v**3, 0.5, title="drag")
    assert [route.name for route in _routes(drag, 2.0)] == ["diffrax Dopri8", "CVODE Adams"]
    t = np.linspace(0, 2, 21)
    one, other = (solution.solution_by(route, drag, t, 1e-10) for route in _routes(drag, 2.0))
    np.testing.assert_allclose(one.u, other.u, atol=1e-7)


def test_a_force_that_remembers_is_solved_by_two_schemes():
    spring = study.materials.elastoplastic(40.0, 4.0, 0.1)
    problem = study.Problem(spring, 0.0, 3.0, title="yielding")
    t = np.linspace(0, 2, 81)
    one, other = (solution.solution_by(route, problem, t, 1e-12) for route in _routes(problem, 2.0))
    np.testing.assert_allclose(one.u, other.u, atol=1e-6)
    assert np.isfinite(one.a).all()
