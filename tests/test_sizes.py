"""The rule for the size that keeps an error, against its definition written out."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from study.sizes import fewest, largest_size, largest_with_margin, least_number


def test_the_fewest_forces_are_those_below_which_nothing_fails():
    forces = xr.DataArray([10.0, 20.0, 40.0, 80.0, np.nan], dims="run")
    error = xr.DataArray([1e-4, 0.5, 1e-3, 1e-4, np.nan], dims="run")
    assert fewest(error, forces, 0.01, "run") == 40
    assert np.isnan(fewest(error, forces, 1e-5, "run"))
    failed = xr.DataArray([1e-4, 1e-4, 1e-4, np.nan, np.nan], dims="run")
    assert np.isnan(fewest(failed, forces, 0.01, "run"))


@pytest.mark.slow
@given(st.lists(st.booleans(), min_size=1, max_size=8), st.randoms())
def test_a_size_counts_only_if_all_finer_ones_keep_the_error(kept, random):
    """Steps in any order: the largest step and the least number of steps are those before the first failure."""
    numbers = random.sample(range(1, 100), len(kept))
    keeps = xr.DataArray(kept, {"number": numbers, "size": ("number", [1 / n for n in numbers])}, "number")
    least = min((n for n in numbers if keeps.where(keeps.number >= n, True).all()), default=np.nan)
    np.testing.assert_equal(least_number(keeps, "number").item(), least)
    largest = largest_size(keeps.swap_dims(number="size"), "size").item()
    assert largest == (0.0 if np.isnan(least) else 1 / least)


def test_runs_from_other_starts_refuse_a_size_and_give_no_margin():
    size, error = np.array([1.0, 0.9, 0.8, 0.7, 0.4]), np.array([0.2, 0.5, 0.2, np.nan, 0.2])
    from_own_start = np.array([True, False, True, True, True])
    assert largest_with_margin(size, error, 0.4, from_own_start) == 0.4  # the failed run refuses all larger sizes
    completed = np.nan_to_num(error, nan=0.2)
    assert largest_with_margin(size, completed, 0.4, from_own_start) == 0.8
    assert largest_with_margin(size, completed, 0.5, from_own_start) == 1.0
    assert largest_with_margin(size, completed, 0.1, from_own_start) == 0.0
