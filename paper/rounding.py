"""How the numbers of 1996 were rounded: first to two decimals, then to one."""

import numpy as np
import xarray as xr


def _half_up(values: xr.DataArray, decimals: int) -> xr.DataArray:
    # a value within round-off of a half counts as a half
    return np.floor(values * 10**decimals + 0.5 + 1e-9) / 10**decimals


def once(values: xr.DataArray) -> xr.DataArray:
    """Rounded to one decimal, halves up."""
    return _half_up(values, 1)


def twice(values: xr.DataArray) -> xr.DataArray:
    """Rounded to two decimals and then to one, halves up."""
    return _half_up(_half_up(values, 2), 1)


def same(a: xr.DataArray, b: xr.DataArray | float) -> xr.DataArray:
    """Whether two arrays of rounded numbers print the same digit."""
    return abs(a - b) < 0.01
