"""Every route to the reference against identities, against each other, and against printed tables of functions."""

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import study
from reference import diffrax, exact, sundials
from study.problems import CubicSpring, TanhSpring, printed_periods

CUBIC = ["hardening", "double_well"]


@pytest.mark.parametrize("name", CUBIC)
def test_closed_form_satisfies_energy_and_start(name):
    problem = study.problems[name]
    t = np.linspace(0.0, 2 * float(exact.period(problem)), 41)
    u, v = exact.trajectory(problem, t)
    energy = np.array([float(problem.energy(a, b)) for a, b in zip(u, v, strict=True)])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-13)
    assert (u[0], v[0]) == pytest.approx((float(problem.u0), 0.0), abs=1e-15)
    np.testing.assert_allclose(u[:21], u[20:], atol=1e-13)


@pytest.mark.parametrize("name", CUBIC)
def test_closed_form_satisfies_the_equation_of_motion(name):
    """Fourth order differences of the exact velocity are −p(u)."""
    problem, h = study.problems[name], 1e-3 * float(exact.period(study.problems[name]))
    t = 0.3 * float(exact.period(problem)) + h * np.arange(-2, 3)
    u, v = exact.trajectory(problem, t)
    acceleration = (v[0] - 8 * v[1] + 8 * v[3] - v[4]) / (12 * h)
    assert acceleration == pytest.approx(-problem.force(u[2]), rel=1e-8)


@pytest.mark.parametrize("name", list(study.problems))
def test_period_is_the_quadrature_of_the_energy(name):
    """T = 2 ∫ du / √(2 (V(u₀) − V(u))) between the turning points, with SciPy and another substitution."""
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
    assert float(exact.period(problem)) == pytest.approx(period, rel=1e-8)


@pytest.mark.parametrize("name", list(study.problems))
def test_digits_of_the_period_do_not_depend_on_the_precision(name, monkeypatch):
    problem = study.problems[name]
    thirty = exact.digits(exact.period(problem))
    monkeypatch.setattr(exact, "DIGITS", 70)
    assert exact.digits(exact.period(problem)) == thirty


def test_small_amplitudes_have_the_linear_period():
    for spring in (CubicSpring(100.0, 10.0), TanhSpring(100.0)):
        problem = study.Problem(spring.force, u0=1e-8, potential=spring.potential)
        assert float(exact.period(problem)) == pytest.approx(2 * np.pi / 10, rel=1e-12)


def test_duffing_period_is_that_of_the_complete_elliptic_integral():
    """T = 4 K(m)/ω with m = S2 u₀²/(2 (1 + S2 u₀²)), SciPy's K."""
    stiffness = 1 + 10 * 1.5**2
    expected = 4 * ellipk(22.5 / (2 * stiffness)) / np.sqrt(100 * stiffness)
    assert float(exact.period(study.problems["hardening"])) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("route", [sundials, diffrax], ids=["CVODE", "diffrax"])
@pytest.mark.parametrize("name", list(study.problems))
def test_routes_meet_the_exact_period(route, name):
    problem = study.problems[name]
    assert route.period(problem, printed_periods[name]) == pytest.approx(float(exact.period(problem)), rel=1e-12)


@pytest.mark.parametrize("route", [sundials, diffrax], ids=["CVODE", "diffrax"])
@pytest.mark.parametrize("name", CUBIC)
def test_routes_meet_the_exact_trajectory(route, name):
    problem = study.problems[name]
    t = np.linspace(0.0, float(exact.period(problem)), 33)
    for found, true in zip(route.trajectory(problem, t), exact.trajectory(problem, t), strict=True):
        np.testing.assert_allclose(found, true, atol=1e-11 * np.abs(true).max())


def test_what_has_no_closed_form_says_so():
    with pytest.raises(ValueError, match="the trajectory of 'softening spring' has no closed form"):
        exact.trajectory(study.problems["softening"], np.zeros(1))
    with pytest.raises(ValueError, match="no closed form is known for 'own'"):
        exact.period(study.Problem(lambda u: u**5, u0=1.0, title="own"))
    over_the_hill = study.Problem(CubicSpring(-0.5, -1.0).force, u0=2.0)
    with pytest.raises(ValueError, match="no closed form is implemented"):
        exact.period(over_the_hill)


def test_a_turning_point_that_is_not_met_says_so():
    with pytest.raises(RuntimeError, match="met no turning point of 'hardening spring'"):
        sundials.period(study.problems["hardening"], 0.01)


def test_precision_of_the_closed_form_is_fifty_digits():
    assert mpmath.mp.dps == 15  # nothing leaks into the caller's context
    assert exact.DIGITS == 50
