"""The observed order of errors that follow a power law."""

import numpy as np
import pytest

from study.analysis.orders import observed_order

STEPS = np.array([8, 16, 24, 48])


@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_order_is_the_power_of_the_step_size(order):
    assert observed_order(STEPS, 3 / STEPS**order) == pytest.approx(order, abs=1e-12)


def test_failed_runs_and_errors_that_do_not_count_are_left_out():
    error = np.array([5.0, 16.0**-2, 24.0**-2, 48.0**-2])
    assert observed_order(STEPS, error, STEPS > 8) == pytest.approx(2, abs=1e-12)
    assert observed_order(STEPS, np.where(STEPS == 8, np.nan, error)) == pytest.approx(2, abs=1e-12)
    assert np.isnan(observed_order(STEPS, error, STEPS > 16)) and np.isnan(observed_order(STEPS, 0 * error))
