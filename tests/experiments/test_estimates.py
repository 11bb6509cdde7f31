"""Estimates and true errors of steps, under a load and with a stiff mode."""

import numpy as np
import pytest

import study
from study.experiments.estimates import estimates, true_errors

SCHEMES = ["average_acceleration", "generalized_alpha"]


@pytest.mark.slow
def test_true_errors_under_a_load_are_those_of_the_closed_form():
    """The exact motion of the forced oscillator is known from any state and start time."""
    problem = study.Problem(lambda u: u, 0.3, 0.1, load=lambda t: t * t)
    ds = study.run(problem, "average_acceleration", controller=study.Prescribed([0.2]), duration=2.0)
    t, u, v, h = ds.t.values, ds.u.values, ds.v.values, 0.2
    # t² − 2 is a particular solution, so the difference from it is a free motion
    free, speed = u[:-1] - (t[:-1] ** 2 - 2), v[:-1] - 2 * t[:-1]
    exact_u = t[1:] ** 2 - 2 + free * np.cos(h) + speed * np.sin(h)
    exact_v = 2 * t[1:] + speed * np.cos(h) - free * np.sin(h)
    displacement_error, motion_error = true_errors(problem, ds)
    expected = abs(u[1:] - exact_u) / abs(u).max()
    np.testing.assert_allclose(displacement_error, expected, rtol=1e-6)
    np.testing.assert_allclose(motion_error, np.maximum(expected, abs(v[1:] - exact_v) / abs(v).max()), rtol=1e-6)


def test_a_stiff_mode_fools_the_estimate():
    """It alone compares an estimate with the errors of several unknowns."""
    ds = estimates(["stiff_soft"], SCHEMES, ["zienkiewicz_xie"], [20]).squeeze()
    average, generalized = (ds.estimate / ds.true_displacement_error).values
    assert generalized > 10 and average > 5 * generalized


def test_a_kink_fools_the_parabola():
    """It alone makes the dataset of several problems and estimators."""
    ds = estimates(["pulse", "yielding"], SCHEMES, ["zienkiewicz_xie", "three_point"], [20, 40])
    ratio = ds.estimate / ds.true_displacement_error
    assert ratio.sel(problem="pulse", estimator="zienkiewicz_xie").values == pytest.approx(1, abs=0.2)
    kink = (ds.estimate / ds.true_error).sel(problem="pulse", estimator="three_point", scheme="average_acceleration")
    assert kink[1] > 1.5 * kink[0]
    assert ds.estimate.sel(problem="yielding").isnull().all()
    blind = ds.linear_ratio.sel(scheme="average_acceleration", estimator="zienkiewicz_xie")
    assert blind.sel(phase=0.5) == pytest.approx(0, abs=1e-12) and blind.sel(phase=0.25) == pytest.approx(1)
