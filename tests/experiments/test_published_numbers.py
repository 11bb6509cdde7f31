"""Errors at times at which the displacement is known, and the Lyapunov exponent of Ueda's oscillator."""

import numpy as np
import pytest

from study.experiments.published_numbers import published_numbers
from study.experiments.ueda import ueda
from study.problem.oscillators import UEDA_EXPONENT

SCHEMES = ["average_acceleration", "central_difference", "rk4", "energy_momentum"]


@pytest.fixture(scope="module")
def found():
    coarsest = [{"problem": "double_pendulum", "steps": 256}, {"problem": "loaded_bar", "steps": 32}]
    return published_numbers(coarsest, 3, SCHEMES, ["double_pendulum"], [1e-4, 1e-6])


def test_errors_fall_with_the_order_of_the_scheme(found):
    error = found.error.sel(problem="double_pendulum")
    fall = np.log(error.isel(refinement=0) / error.isel(refinement=1)) / np.log(4)
    np.testing.assert_allclose(fall.sel(scheme=["average_acceleration", "central_difference"]), 2.0, atol=0.1)
    assert fall.sel(scheme="rk4") == pytest.approx(4.0, abs=0.2)


def test_central_difference_is_exact_at_a_step_of_an_element(found):
    bar = found.sel(problem="loaded_bar", scheme="central_difference")
    assert bar.steps.values.tolist() == [32, 128, 512]
    assert np.isnan(bar.error[0]) and bar.status[0] != 0
    assert bar.error[1] < 1e-13 < bar.error[2]


def test_what_a_scheme_refuses_has_no_error(found):
    refused = found.sel(problem="double_pendulum", scheme="energy_momentum")
    assert refused.error.isnull().all()
    assert (refused.status == found.status.flag_meanings.split().index("not_run")).all()
    assert found.error.sel(problem="loaded_bar", scheme="energy_momentum").notnull().all()


def test_a_finer_tolerance_makes_more_steps_and_less_error(found):
    pendulum = found.sel(problem="double_pendulum", scheme=["average_acceleration", "rk4"])
    assert (pendulum.controlled_steps[:, 1] > 2 * pendulum.controlled_steps[:, 0]).all()
    assert (pendulum.controlled_error[:, 1] < pendulum.controlled_error[:, 0] / 2).all()
    assert found.controlled_error.sel(problem="loaded_bar").isnull().all()


def test_a_fine_step_keeps_the_exponent_and_a_long_one_makes_the_motion_regular():
    found = ueda(["average_acceleration"], [24, 64], 400, 16).sel(scheme="average_acceleration")
    assert found.exponent[0] < 0
    assert found.exponent[1] == pytest.approx(UEDA_EXPONENT, rel=0.1)
    # SciPy's DOP853 with tolerances of 1e-8 gives 2.569 over 4,800 periods; the error of second order is 0.8 % here
    assert found.mean_square[1] == pytest.approx(1.008 * 2.569, abs=4 * found.mean_square_uncertainty[1].item())
