"""The solvers (routes) for references, compared with each other, and the arguments that they refuse."""

from functools import partial

import jax.numpy as jnp
import numpy as np
import pytest

import reference.diffrax
import study
from reference import closed_form, exact, scipy, sundials, taylor
from reference.experiments import agreement
from reference.solution import RouteFailed, StepLimit
from study.problem.named import printed_periods
from study.problem.springs import CubicSpring

ROUTES = list(agreement.ROUTES)


@pytest.fixture
def duffing():
    """A forced and damped Duffing oscillator without chaos; its motion has no period."""
    return study.Problem(
        CubicSpring(-1.0, -1.0).force,
        u0=0.5,
        v0=0.1,
        damping=0.3,
        load=lambda t: 0.2 * jnp.cos(1.2 * t),
        title="Duffing",
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "route",
    [
        "cvode_adams",
        "dopri8",
        "heyoka",
        *(pytest.param(route, marks=pytest.mark.exhaustive) for route in ("cvode_bdf", "tsit5", "kvaerno5")),
    ],
)
def test_routes_meet_the_exact_period(route):
    """A solver whose zero crossings are less accurate than its motion."""
    _, period = agreement.ROUTES[route]
    for name in printed_periods:
        value = period(study.problems[name], printed_periods[name], 1e-15)
        assert value == pytest.approx(float(closed_form.period(study.problems[name])), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "route, whole_periods, anywhere",
    [
        ("cvode_adams", 1e-11, 1e-10),
        ("dopri8", 2e-12, 1e-11),
        ("heyoka", 1e-13, 5e-12),
        pytest.param("cvode_bdf", 1e-9, 1e-7, marks=pytest.mark.exhaustive),
        pytest.param("tsit5", 2e-12, 1e-10, marks=pytest.mark.exhaustive),
    ],
)
def test_errors_at_the_tightest_tolerance_over_a_hundred_periods(route, whole_periods, anywhere):
    """An interpolant of a solver that is less accurate between its steps than at them."""
    problem = study.problems["hardening"]
    certified = exact.period(problem, 0.15)
    t = agreement.instants(float(certified[0]))
    trajectory, _ = agreement.ROUTES[route]
    errors = agreement.errors(exact.folded(problem, t, *certified), trajectory(problem, t, 1e-15))
    assert errors["displacement_error_at_periods"][-1] < whole_periods
    assert errors["displacement_error"][-1] < anywhere
    assert np.all(np.diff(errors["displacement_error"]) >= 0)


def test_the_status_of_a_route(monkeypatch):
    """A route that reaches its limit of steps tries no smaller tolerance; the periods are found nevertheless.

    It alone makes the dataset, here of two routes and over a tenth of the periods, with a tenth of the steps that
    Kvaerno5 may take.
    """
    monkeypatch.setattr(agreement, "WINDOWS", (1, 10))
    trajectory, period = agreement.ROUTES["kvaerno5"]
    routes = {"kvaerno5": (partial(trajectory, max_steps=3000), period), "heyoka": agreement.ROUTES["heyoka"]}
    monkeypatch.setattr(agreement, "ROUTES", routes)
    ds = agreement.agreement(["hardening"], [1e-9, 1e-13, 1e-15]).squeeze("problem")
    ended = [agreement.FINISHED, agreement.STEP_LIMIT, agreement.NOT_TRIED]
    np.testing.assert_array_equal(ds.status.sel(route="kvaerno5"), ended)
    assert np.isnan(ds.displacement_error.sel(route="kvaerno5").values[1:]).all()
    assert (ds.period_error.min("tolerance") < 1e-12).all()


@pytest.mark.slow
def test_every_route_solves_a_damped_and_forced_problem(duffing):
    """It alone gives the routes a damping and a load."""
    t = np.linspace(1.0, 60.0, 60)
    truth = exact.trajectory(duffing, t)
    assert truth.u_certified < 1e-30
    for name, (trajectory, _) in agreement.ROUTES.items():
        solution = trajectory(duffing, t, 1e-12 if name != "kvaerno5" else 1e-8)
        allowed = {"cvode_bdf": 1e-8, "kvaerno5": 1e-5}.get(name, 1e-9)
        np.testing.assert_allclose(solution.u, truth.u, atol=allowed, err_msg=name)
        np.testing.assert_allclose(solution.v, truth.v, atol=allowed, err_msg=name)


def test_a_problem_without_period_says_so(duffing):
    for _, period in agreement.ROUTES.values():
        with pytest.raises(ValueError, match=r"finds no period of 'Duffing': it is (damped|loaded)"):
            period(duffing, 5.0, 1e-9)
        resting = study.Problem(lambda u: u, u0=0.0, title="resting")
        with pytest.raises(ValueError, match="it starts in equilibrium"):
            period(resting, 5.0, 1e-9)
        moving = study.Problem(lambda u: u, u0=1.0, v0=1.0, title="moving")
        with pytest.raises(ValueError, match="it does not start from rest"):
            period(moving, 5.0, 1e-9)


@pytest.mark.parametrize("route", ROUTES)
def test_a_tolerance_out_of_reach_is_refused(route):
    trajectory, _ = agreement.ROUTES[route]
    with pytest.raises(ValueError, match=r"cannot reach a tolerance of 1e-17; ask for .* or more"):
        trajectory(study.problems["hardening"], np.array([0.1]), 1e-17)


@pytest.mark.parametrize("t", [[], [np.nan], [-1.0], [0.2, 0.1], [0.1, 0.1]])
def test_times_that_do_not_increase_are_refused(t):
    for trajectory, _ in agreement.ROUTES.values():
        with pytest.raises(ValueError, match="needs times that are finite and increase from zero on"):
            trajectory(study.problems["hardening"], np.array(t), 1e-6)
    with pytest.raises(ValueError, match="needs times that are finite and increase from zero on"):
        exact.trajectory(study.problems["hardening"], t)


def test_routes_for_one_unknown_refuse_more():
    two = study.Problem(lambda u: u, u0=[1.0, 2.0], v0=[0.0, 0.0], title="two")
    for trajectory in (taylor.trajectory, scipy.trajectory):
        with pytest.raises(ValueError, match="'two' has 2 unknowns"):
            trajectory(two, np.array([1.0]), 1e-6)
    for _, period in agreement.ROUTES.values():
        with pytest.raises(ValueError, match="it has more than one unknown"):
            period(two, 1.0, 1e-6)


@pytest.mark.parametrize("estimate", [-1.0, 0.0, np.nan])
def test_a_period_needs_a_sensible_estimate(estimate):
    for _, period in agreement.ROUTES.values():
        with pytest.raises(ValueError, match="needs a rough period of 'hardening spring' that is greater than zero"):
            period(study.problems["hardening"], estimate, 1e-6)


def test_tolerances_must_fall():
    with pytest.raises(ValueError, match=r"the tolerances must be in descending order, not \[1e-12, 0.0001\]"):
        agreement.agreement(["hardening"], [1e-12, 1e-4])


def test_a_limit_of_steps_names_the_route():
    with pytest.raises(StepLimit, match="CVODE Adams did not finish 'hardening spring'"):
        sundials.trajectory(study.problems["hardening"], np.array([1.0]), max_num_steps=10)
    with pytest.raises(StepLimit, match="CVODE Adams did not finish 'hardening spring'"):
        sundials.trajectory(study.problems["hardening"], np.array([1.0, 2.0, 3.0]), max_num_steps=10)
    with pytest.raises(StepLimit, match="diffrax Dopri8 did not finish 'hardening spring': the limit of its steps"):
        reference.diffrax.trajectory(study.problems["hardening"], np.array([1.0]), max_steps=10)


@pytest.mark.parametrize("route", ROUTES)
def test_a_turning_point_that_is_not_met_says_so(route):
    _, period = agreement.ROUTES[route]
    with pytest.raises(RouteFailed, match="met no turning point of 'hardening spring' up to t = 0.0075"):
        period(study.problems["hardening"], 0.01, 1e-9)
