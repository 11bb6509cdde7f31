"""The closed form of the ratio of estimate to true error, compared with runs of an oscillator at two step sizes."""

import numpy as np
import pytest

import study
from study.control.leading import linear_ratio
from study.experiments.estimates import true_errors

OSCILLATOR = study.Problem(lambda u: u, u0=1.0)
ESTIMATORS = ["zienkiewicz_xie", "zienkiewicz_xie_balance", "three_point", "half_step_residual"]
DOUBLED = ["average_acceleration", "central_difference", "bathe", "rk4"]
CARRIED = ["average_acceleration", "central_difference", "hht_alpha", "wbz_alpha", "generalized_alpha"]
CASES = [(scheme, estimator) for scheme in CARRIED for estimator in ESTIMATORS]


def _distance(scheme, estimator, steps):
    """Largest difference between the measured ratio and its closed form, relative to the largest ratio.

    The first third of the period is left out.
    """
    equal = study.Prescribed([2 * np.pi / steps])
    ds = study.run(OSCILLATOR, scheme, controller=equal, duration=2 * np.pi, estimator=estimator)
    part = (np.arange(steps) + 0.5) / steps
    closed = linear_ratio(study.schemes[scheme], estimator, part, steps)
    measured = ds.estimate.values[1:] / true_errors(OSCILLATOR, ds)[1]
    return np.abs(measured - closed)[part > 1 / 3].max() / closed.max()


@pytest.mark.parametrize("scheme, estimator", [*CASES, *((scheme, "step_doubling") for scheme in DOUBLED)])
def test_the_measured_ratio_tends_to_the_closed_form(scheme, estimator):
    coarse, fine = (_distance(scheme, estimator, steps) for steps in (80, 320))
    assert fine < 0.025 and fine < 0.4 * coarse


@pytest.mark.parametrize("scheme, estimator", [("hht_alpha", "step_doubling"), ("rk4", "three_point")])
def test_no_closed_form_is_claimed_where_none_is_known(scheme, estimator):
    assert np.isnan(linear_ratio(study.schemes[scheme], estimator, np.array([0.3]), 80)).all()


def test_zienkiewicz_and_xie_are_blind_at_turning_points():
    ratio = linear_ratio(study.schemes["average_acceleration"], "zienkiewicz_xie", np.array([0.0, 1 / 16, 1 / 4]), 80)
    np.testing.assert_allclose(ratio, [0, np.tan(np.pi / 8), 1])
