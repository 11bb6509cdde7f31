"""The reference solution and its certificate."""

from fractions import Fraction

import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

import study
from reference import closed_form, exact, taylor
from reference.experiments import springs
from reference.solution import RouteFailed
from study.problem.named import approximate_periods, printed_periods
from study.problem.springs import CubicSpring

CUBIC = ["hardening", "double_well"]


@pytest.mark.slow
@pytest.mark.parametrize("name", list(printed_periods))
def test_period_is_certified_to_thirty_digits(name):
    period, certified = exact.period(study.problems[name], approximate_periods[name])
    assert certified < 1e-36
    with mpmath.workdps(50):
        assert abs(closed_form.period(study.problems[name]) / mpmath.mpf(str(period)) - 1) < 1e-36


@pytest.mark.slow
@pytest.mark.parametrize("name", list(approximate_periods))
def test_motion_is_certified_and_closes_after_a_period(name):
    problem = study.problems[name]
    period, _ = exact.period(problem, approximate_periods[name])
    truth = exact.trajectory(problem, [period * k / 16 for k in range(17)])
    assert truth.u_certified < 1e-34 and truth.v_certified < 1e-33
    assert (truth.u[-1], truth.v[-1]) == pytest.approx((float(problem.u0), 0.0), rel=0, abs=1e-30)
    energy = np.array([problem.energy(u, v) for u, v in zip(truth.u, truth.v, strict=True)])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-14)


@pytest.mark.slow
def test_folding_is_the_long_integration():
    """Times in the hundredth period are folded into the first; the motion equals a run of 128 bits over all periods."""
    problem = study.problems["softening"]
    t = np.array([113.7, 113.9, 114.05])
    truth = exact.folded(problem, t, *exact.period(problem, 1.14))
    last = taylor.trajectory(problem, t, bits=128)
    np.testing.assert_array_equal(truth.u, [float(u) for u in last.u])
    np.testing.assert_array_equal(truth.v, [float(v) for v in last.v])


@pytest.mark.slow
@pytest.mark.parametrize("name", CUBIC)
def test_the_reference_after_a_hundred_thousand_periods_is_the_closed_form(name):
    """The times are in any order. Some are whole periods, where rounding decides on which side a time lies."""
    problem, certified = study.problems[name], exact.period(study.problems[name], approximate_periods[name])
    period = float(certified[0])
    t = np.concatenate(
        [np.random.default_rng(1).uniform(0, 1e5 * period, 20), period * np.array([1e5, 1.0, 0.0, 99_999.0])]
    )
    truth = exact.folded(problem, t, *certified)
    u, v = closed_form.trajectory(problem, t)
    np.testing.assert_array_equal(truth.u, np.array(u, float))
    np.testing.assert_allclose(truth.v, np.array(v, float), rtol=1e-15, atol=1e-30)
    assert truth.u_certified < 1e-30


def test_a_time_that_is_not_finite_is_refused():
    problem = study.problems["hardening"]
    with pytest.raises(ValueError, match="the exact solution of 'hardening spring' needs finite times"):
        exact.folded(problem, [np.nan], *exact.period(problem, 0.15))


@pytest.mark.slow
def test_a_period_needs_no_closed_form():
    quintic = study.Problem(lambda u: u + u**5, u0=1.0, title="quintic")
    period, certified = exact.period(quintic, 5.0)
    assert certified < 1e-36
    assert taylor.period(quintic, 5.0) == pytest.approx(float(period), rel=1e-14)


def test_digits_on_which_the_integrations_differ_are_refused():
    """An exact solution of a chaotic motion that states more digits than hold."""
    chaotic = study.Problem(
        CubicSpring(-1.0, -1.0).force, u0=0.5, damping=0.3, load=lambda t: 0.5 * jnp.cos(1.2 * t), title="chaotic"
    )
    with pytest.raises(RouteFailed, match=r"the exact solution of 'chaotic' up to t = 600 is known to .* only"):
        exact.trajectory(chaotic, [600.0])


def test_phases_hold_every_step_of_every_step_size():
    parts = springs.phases([8, 11])
    assert len(parts) == 8 + 11 - 1 + 1
    assert Fraction(3, 8) in parts and Fraction(10, 11) in parts and parts[0] == 0 and parts[-1] == 1
