"""Every route to the reference against identities, against each other, and in what it refuses."""

import inspect
import re
from fractions import Fraction

import heyoka as hy
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import reference.diffrax
import study
from reference import agreement, closed_form, exact, scipy, sundials, taylor
from reference.solution import RouteFailed, StepLimit
from reference.symbolic import as_python, expression, first_order, with_force_as_state
from study.problem.named import printed_periods
from study.problem.springs import CubicSpring, TanhSpring

CUBIC = ["hardening", "double_well"]
ROUTES = list(agreement.ROUTES)


@pytest.fixture
def duffing():
    """A forced and damped Duffing oscillator before chaos sets in: no period to fold."""
    return study.Problem(
        CubicSpring(-1.0, -1.0).force,
        u0=0.5,
        v0=0.1,
        damping=0.3,
        load=lambda t: 0.2 * jnp.cos(1.2 * t),
        title="Duffing",
    )


@pytest.mark.parametrize("name", list(printed_periods))
def test_period_is_certified_to_thirty_digits(name):
    period, certified = exact.period(study.problems[name], printed_periods[name])
    assert certified < 1e-36
    with mpmath.workdps(50):
        assert abs(closed_form.period(study.problems[name]) / mpmath.mpf(str(period)) - 1) < 1e-36


@pytest.mark.parametrize("name", list(printed_periods))
def test_motion_is_certified_and_closes_after_a_period(name):
    problem = study.problems[name]
    period, _ = exact.period(problem, printed_periods[name])
    truth = exact.trajectory(problem, [period * k / 16 for k in range(17)])
    assert truth.u_certified < 1e-34 and truth.v_certified < 1e-33
    assert (truth.u[-1], truth.v[-1]) == pytest.approx((float(problem.u0), 0.0), rel=0, abs=1e-30)
    energy = np.array([problem.energy(u, v) for u, v in zip(truth.u, truth.v, strict=True)])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-14)


@pytest.mark.parametrize("name", CUBIC)
def test_closed_form_is_the_truth(name):
    problem = study.problems[name]
    period, _ = exact.period(problem, printed_periods[name])
    times = [period * k / 16 for k in range(17)]
    truth = exact.trajectory(problem, times)
    u, v = closed_form.trajectory(problem, [mpmath.mpf(str(t)) for t in times])
    np.testing.assert_allclose(np.array(u, float), truth.u, rtol=0, atol=1e-15 * np.abs(truth.u).max())
    np.testing.assert_allclose(np.array(v, float), truth.v, rtol=0, atol=1e-15 * np.abs(truth.v).max())


@pytest.mark.parametrize("name", list(printed_periods))
def test_period_is_the_quadrature_of_the_energy(name):
    """T = 2 ∫ du / √(2 (V(u₀) − V(u))) between the turning points, in double precision with another substitution."""
    problem = study.problems[name]
    u0 = float(problem.u0)

    def drop(u):
        return float(problem.potential(u0)) - float(problem.potential(u))

    other = brentq(drop, 1.1, 1.5, xtol=1e-15) if name == "double_well" else -u0
    middle, half = (u0 + other) / 2, (u0 - other) / 2

    def integrand(x):
        """With u = middle + half (3x − x³)/2 the integrand is regular at both ends."""
        return abs(half) * 1.5 * (1 - x * x) / np.sqrt(2 * drop(middle + half * (3 * x - x**3) / 2))

    nodes, weights = np.polynomial.legendre.leggauss(200)
    period = 2 * sum(w * integrand(x) for x, w in zip(nodes, weights, strict=True))
    assert float(closed_form.period(problem)) == pytest.approx(period, rel=1e-8)


def test_small_amplitudes_have_the_linear_period():
    for spring in (CubicSpring(100.0, 10.0), TanhSpring(100.0)):
        problem = study.Problem(spring.force, u0=1e-8, potential=spring.potential)
        assert float(closed_form.period(problem)) == pytest.approx(2 * np.pi / 10, rel=1e-12)


def test_duffing_period_is_that_of_the_complete_elliptic_integral():
    """T = 4 K(m)/ω with m = S2 u₀²/(2 (1 + S2 u₀²)), SciPy's K."""
    stiffness = 1 + 10 * 1.5**2
    expected = 4 * ellipk(22.5 / (2 * stiffness)) / np.sqrt(100 * stiffness)
    assert float(closed_form.period(study.problems["hardening"])) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("route", ROUTES)
def test_routes_meet_the_exact_period(route):
    _, period = agreement.ROUTES[route]
    for name in printed_periods:
        found = period(study.problems[name], printed_periods[name], 1e-15)
        assert found == pytest.approx(float(closed_form.period(study.problems[name])), rel=1e-12)


@pytest.mark.parametrize(
    "route, whole_periods, anywhere",
    [("cvode_adams", 1e-11, 1e-10), ("cvode_bdf", 1e-9, 1e-7), ("dopri8", 2e-12, 1e-11), ("tsit5", 2e-12, 1e-10),
     ("heyoka", 1e-13, 5e-12)],
)  # fmt: skip
def test_what_the_tightest_tolerance_delivers_over_a_hundred_periods(route, whole_periods, anywhere):
    problem = study.problems["hardening"]
    found = exact.period(problem, 0.15)
    t = agreement.instants(float(found[0]))
    trajectory, _ = agreement.ROUTES[route]
    errors = agreement.errors(problem, exact.folded(problem, t, *found), trajectory(problem, t, 1e-15))
    assert errors["u_error_at_periods"][-1] < whole_periods
    assert errors["u_error"][-1] < anywhere
    assert np.all(np.diff(errors["u_error"]) >= 0)


def test_folding_is_the_long_integration():
    """The truth of the hundredth period, folded, against a run of 128 bits through all of them."""
    problem = study.problems["softening"]
    t = np.array([113.7, 113.9, 114.05])
    truth = exact.folded(problem, t, *exact.period(problem, 1.14))
    last = taylor.trajectory(problem, t, bits=128)
    np.testing.assert_array_equal(truth.u, [float(u) for u in last.u])
    np.testing.assert_array_equal(truth.v, [float(v) for v in last.v])


@pytest.mark.parametrize("name", CUBIC)
def test_truth_after_a_hundred_thousand_periods_is_the_closed_form(name):
    """At any time, in any order, also at whole periods, where rounding decides which side of them a time lies."""
    problem, found = study.problems[name], exact.period(study.problems[name], printed_periods[name])
    once = float(found[0])
    t = np.concatenate(
        [np.random.default_rng(1).uniform(0, 1e5 * once, 20), once * np.array([1e5, 1.0, 0.0, 99_999.0])]
    )
    truth = exact.folded(problem, t, *found)
    u, v = closed_form.trajectory(problem, t)
    np.testing.assert_array_equal(truth.u, np.array(u, float))
    np.testing.assert_allclose(truth.v, np.array(v, float), rtol=1e-15, atol=1e-30)
    assert truth.u_certified < 1e-30


def test_a_time_that_is_not_finite_is_refused():
    problem = study.problems["hardening"]
    with pytest.raises(ValueError, match="'hardening spring' is asked for at a time that is not finite"):
        exact.folded(problem, [np.nan], *exact.period(problem, 0.15))


def test_how_a_route_ended_is_told():
    """A limit of steps stops the ladder of a trajectory, and keeps no period from being found."""
    ds = agreement.agreement(["hardening"], [1e-9, 1e-13, 1e-15]).squeeze("problem")
    ended = [agreement.FINISHED, agreement.STEP_LIMIT, agreement.NOT_TRIED]
    np.testing.assert_array_equal(ds.status.sel(route="kvaerno5"), ended)
    assert np.isnan(ds.u_error.sel(route="kvaerno5").values[1:]).all()
    assert (ds.period_status == agreement.FINISHED).all()
    assert (ds.period_error.min("tolerance") < 1e-12).all()


def test_a_damped_and_forced_problem_has_a_truth_and_every_route_meets_it(duffing):
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
        with pytest.raises(ValueError, match="it starts in balance"):
            period(resting, 5.0, 1e-9)
        moving = study.Problem(lambda u: u, u0=1.0, v0=1.0, title="moving")
        with pytest.raises(ValueError, match="it does not start from rest"):
            period(moving, 5.0, 1e-9)


@pytest.mark.parametrize("route", ROUTES)
def test_a_tolerance_out_of_reach_is_refused(route):
    trajectory, _ = agreement.ROUTES[route]
    with pytest.raises(ValueError, match=r"cannot reach a tolerance of 1e-17; ask for .* or more"):
        trajectory(study.problems["hardening"], np.array([0.1]), 1e-17)


def test_a_period_needs_no_closed_form():
    quintic = study.Problem(lambda u: u + u**5, u0=1.0, title="quintic")
    period, certified = exact.period(quintic, 5.0)
    assert certified < 1e-36
    assert taylor.period(quintic, 5.0) == pytest.approx(float(period), rel=1e-14)


def test_every_route_solves_the_same_constants():
    """Not constants that were rounded on their way to a solver."""
    problem = study.Problem(CubicSpring(100.0, 10.0).force, u0=0.1, damping=1 / 3, mass=1.0000000000000047)
    states, (_, rate) = ["u", "v"], first_order(problem)[1]
    u, v = hy.make_vars(*states)
    compiled, python = hy.cfunc([rate], [u, v]), as_python(problem)
    for point in np.random.default_rng(2).uniform(-1, 1, (20, 2)):
        assert python(0.0, *point) == pytest.approx(compiled(point)[0], rel=1e-15, abs=0)
    constants = [float(number) for number in re.findall(r"\d+\.\d+", inspect.getsource(python))]
    assert 1 / 3 / 1.0000000000000047 == pytest.approx(constants[-1], rel=2e-16, abs=0)


def test_what_the_integrations_do_not_agree_on_is_no_truth():
    chaotic = study.Problem(
        CubicSpring(-1.0, -1.0).force, u0=0.5, damping=0.3, load=lambda t: 0.5 * jnp.cos(1.2 * t), title="chaotic"
    )
    assert exact.trajectory(chaotic, [50.0]).u_certified < 1e-25
    with pytest.raises(RouteFailed, match=r"the exact solution of 'chaotic' up to t = 900 is known to .* only"):
        exact.trajectory(chaotic, [900.0])


@pytest.mark.parametrize("t", [[], [np.nan], [-1.0], [0.2, 0.1], [0.1, 0.1]])
def test_times_that_do_not_increase_are_refused(t):
    for trajectory, _ in agreement.ROUTES.values():
        with pytest.raises(ValueError, match="needs times that are finite and increase from zero on"):
            trajectory(study.problems["hardening"], np.array(t), 1e-6)
    with pytest.raises(ValueError, match="needs times that are finite and increase from zero on"):
        exact.trajectory(study.problems["hardening"], t)


def test_more_than_one_unknown_is_refused_where_it_must_be():
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
    with pytest.raises(ValueError, match=r"the tolerances must fall, not \[1e-12, 0.0001\]"):
        agreement.agreement(["hardening"], [1e-12, 1e-4])


def test_a_damped_spring_has_no_closed_form():
    damped = study.Problem(CubicSpring(100.0, 10.0).force, u0=1.5, damping=5.0, title="damped")
    with pytest.raises(ValueError, match="no closed form is known for 'damped'"):
        closed_form.period(damped)


def test_a_limit_of_steps_names_the_route():
    with pytest.raises(StepLimit, match="CVODE Adams did not finish 'hardening spring'"):
        sundials.trajectory(study.problems["hardening"], np.array([1.0]), max_num_steps=10)
    with pytest.raises(StepLimit, match="diffrax Dopri8 did not finish 'hardening spring': The maximum number"):
        reference.diffrax.trajectory(study.problems["hardening"], np.array([1.0]), max_steps=10)


@pytest.mark.parametrize("route", ROUTES)
def test_a_turning_point_that_is_not_met_says_so(route):
    _, period = agreement.ROUTES[route]
    with pytest.raises(RouteFailed, match="met no turning point of 'hardening spring'"):
        period(study.problems["hardening"], 0.01, 1e-9)


def test_what_has_no_closed_form_says_so():
    with pytest.raises(ValueError, match="the trajectory of 'softening spring' has no closed form"):
        closed_form.trajectory(study.problems["softening"], np.zeros(1))
    with pytest.raises(ValueError, match="no closed form is known for 'own'"):
        closed_form.period(study.Problem(lambda u: u**5, u0=1.0, title="own"))
    without_rest = study.Problem(CubicSpring(-0.5, 1.0).force, u0=2.0)
    with pytest.raises(ValueError, match="no closed form is implemented"):
        closed_form.period(without_rest)


def test_translation_keeps_the_function():
    """A JAX function and its heyoka expression agree on random arguments."""
    u = hy.make_vars("u")
    for function in (
        study.problems["softening"].force,
        lambda x: jnp.sin(x) * jnp.exp(-(x**2)) / (2.0 + jnp.cos(3.0 * x)),
        lambda x: x**3 - 0.5 * x + jnp.sqrt(1.0 + x * x),
        lambda x: jnp.arctan(x) + jnp.log1p(x * x) * jnp.arcsinh(x) + jnp.expm1(-x) * jnp.tan(x / 2),
    ):
        compiled = hy.cfunc([expression(function, u)], [u])
        for x in np.random.default_rng(0).uniform(-2, 2, 20):
            assert compiled(np.array([x]))[0] == pytest.approx(float(function(x)), rel=1e-13)


def test_what_is_not_smooth_is_refused():
    with pytest.raises(ValueError, match="'abs' has no translation"):
        first_order(study.Problem(lambda u: jnp.abs(u) * u, u0=1.0))
    with pytest.raises(ValueError, match="has 2 unknowns"):
        first_order(study.Problem(lambda u: u, u0=[1.0, 2.0], v0=[0.0, 0.0]))


def test_the_second_formulation_does_not_evaluate_the_force():
    (_, _), (_, acceleration), (_, _) = with_force_as_state(study.problems["softening"])
    assert "tanh" not in str(acceleration)
    assert "tanh" in str(first_order(study.problems["softening"])[1][1])


def test_phases_hold_every_step_of_every_step_size():
    parts = exact.phases([8, 11])
    assert len(parts) == 8 + 11 - 1 + 1
    assert Fraction(3, 8) in parts and Fraction(10, 11) in parts and parts[0] == 0 and parts[-1] == 1
