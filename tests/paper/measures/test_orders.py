"""Observed orders of convergence."""

import numpy as np
import pytest
import xarray as xr

from paper.measures.orders import order_at_finest


@pytest.mark.parametrize("order", [1, 2, 5])
def test_a_power_law_is_found(order):
    steps = np.array([8, 16, 32, 64, 128, 256])
    error = xr.DataArray(
        0.3 * (steps / 8.0) ** -order, {"steps_per_period": steps}, attrs={"units": "1"}, name="displacement_error"
    )
    assert order_at_finest(error) == pytest.approx(order, abs=1e-9)


def test_errors_that_follow_no_power_law_have_no_order():
    steps = np.array([8, 16, 32, 64, 128, 256])
    crossing = xr.DataArray(
        1e-3 * np.array([8, 4, 1, 0.01, -0.2, -0.3]),
        {"steps_per_period": steps},
        attrs={"units": "1"},
        name="phase_error",
    )
    assert np.isnan(order_at_finest(crossing))
    floor = xr.DataArray(np.full(6, 1e-13), {"steps_per_period": steps}, attrs={"units": "1"}, name="phase_error")
    assert np.isnan(order_at_finest(floor))
