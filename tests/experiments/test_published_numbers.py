"""Errors at times at which the displacement is known."""

import numpy as np
import pytest

from study.experiments.published_numbers import published_numbers

SCHEMES = ["average_acceleration", "central_difference", "rk4", "energy_momentum"]


@pytest.fixture(scope="module")
def ds():
    coarsest = [{"problem": "double_pendulum", "steps": 256}, {"problem": "loaded_bar", "steps": 32}]
    return published_numbers(coarsest, 3, SCHEMES, ["double_pendulum"], [1e-4, 1e-6])


def test_errors_fall_with_the_order_of_the_scheme(ds):
    error = ds.end_error.sel(problem="double_pendulum")
    fall = np.log(error.isel(refinement=0) / error.isel(refinement=1)) / np.log(4)
    np.testing.assert_allclose(fall.sel(scheme=["average_acceleration", "central_difference"]), 2.0, atol=0.1)
    assert fall.sel(scheme="rk4") == pytest.approx(4.0, abs=0.2)


def test_central_difference_is_exact_at_a_step_of_an_element(ds):
    bar = ds.sel(problem="loaded_bar", scheme="central_difference")
    assert bar.steps.values.tolist() == [32, 128, 512]
    assert np.isnan(bar.end_error[0]) and bar.status[0] != 0
    assert bar.end_error[1] < 1e-13 < bar.end_error[2]


def test_what_a_scheme_refuses_has_no_error(ds):
    refused = ds.sel(problem="double_pendulum", scheme="energy_momentum")
    assert refused.end_error.isnull().all()
    assert (refused.status == ds.status.flag_meanings.split().index("not_run")).all()
    assert ds.end_error.sel(problem="loaded_bar", scheme="energy_momentum").notnull().all()


def test_a_finer_tolerance_makes_more_steps_and_less_error(ds):
    pendulum = ds.sel(problem="double_pendulum", scheme=["average_acceleration", "rk4"])
    assert (pendulum.controlled_steps[:, 1] > 2 * pendulum.controlled_steps[:, 0]).all()
    assert (pendulum.controlled_end_error[:, 1] < pendulum.controlled_end_error[:, 0] / 2).all()
    assert ds.controlled_end_error.sel(problem="loaded_bar").isnull().all()
