"""Periods and motions in closed form."""

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import study
from reference import closed_form, exact
from study.problem.named import printed_periods
from study.problem.springs import CubicSpring, TanhSpring

CUBIC = ["hardening", "double_well"]


@pytest.mark.parametrize("name", CUBIC)
def test_the_closed_form_is_the_reference(name):
    problem = study.problems[name]
    period, _ = exact.period(problem, printed_periods[name])
    times = [period * k / 16 for k in range(17)]
    truth = exact.trajectory(problem, times)
    u, v = closed_form.trajectory(problem, [mpmath.mpf(str(t)) for t in times])
    np.testing.assert_allclose(np.array(u, float), truth.u, rtol=0, atol=1e-15 * np.abs(truth.u).max())
    np.testing.assert_allclose(np.array(v, float), truth.v, rtol=0, atol=1e-15 * np.abs(truth.v).max())


@pytest.mark.slow
@pytest.mark.parametrize("name", list(printed_periods))
def test_period_is_the_quadrature_of_the_energy(name):
    """T = 2 ∫ du / √(2 (V(u₀) − V(u))) between the turning points, in double precision by Gauss's quadrature."""
    problem = study.problems[name]
    u0 = float(problem.u0)

    def drop(u):
        return float(problem.potential(u0)) - float(problem.potential(u))

    turning = brentq(drop, 1.1, 1.5, xtol=1e-15) if name == "double_well" else -u0
    middle, half = (u0 + turning) / 2, (u0 - turning) / 2

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
    """T = 4 K(m)/ω with ω² = S1 (1 + S2 u₀²), m = S2 u₀²/(2 (1 + S2 u₀²)), and K from SciPy."""
    stiffness = 1 + 10 * 1.5**2
    expected = 4 * ellipk(22.5 / (2 * stiffness)) / np.sqrt(100 * stiffness)
    assert float(closed_form.period(study.problems["hardening"])) == pytest.approx(expected, rel=1e-14)


def test_a_damped_spring_has_no_closed_form():
    damped = study.Problem(CubicSpring(100.0, 10.0).force, u0=1.5, damping=5.0, title="damped")
    with pytest.raises(ValueError, match="no closed form is known for 'damped'"):
        closed_form.period(damped)


def test_problems_without_a_closed_form_are_refused():
    with pytest.raises(ValueError, match="the trajectory of 'softening spring' has no closed form"):
        closed_form.trajectory(study.problems["softening"], np.zeros(1))
    with pytest.raises(ValueError, match="no closed form is known for 'own'"):
        closed_form.period(study.Problem(lambda u: u**5, u0=1.0, title="own"))
    without_rest = study.Problem(CubicSpring(-0.5, 1.0).force, u0=2.0)
    with pytest.raises(ValueError, match="no closed form is implemented"):
        closed_form.period(without_rest)
