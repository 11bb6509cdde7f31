"""The numbers printed in 1996, as labelled arrays checked by hand against the paper, and the rules of rounding."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

_HERE = Path(__file__).parent


def _printed(file: str, index: list[str], value: str) -> xr.DataArray:
    table = pd.read_csv(_HERE / file)
    order = {name: table[name].unique() for name in index}
    return table.set_index(index)[value].to_xarray().reindex(order)


def printed_energy_errors() -> xr.DataArray:
    """Tables 1 and 2: largest energy error in percent for each problem, steps_per_period and scheme."""
    return _printed("energy_error.csv", ["problem", "steps_per_period", "scheme"], "max_energy_error_percent")


def printed_cpu_times() -> xr.DataArray:
    """Last rows of Tables 1 and 2: seconds of 100,000 steps on a Pentium of 90 MHz, over problem and scheme."""
    return _printed("cpu_time.csv", ["problem", "scheme"], "cpu_seconds_100000_steps_pentium90")


#: Schemes, problems and steps per period of Tables 1 and 2, in their order.
SCHEMES: list[str] = printed_energy_errors().scheme.values.tolist()
PROBLEMS: list[str] = printed_energy_errors().problem.values.tolist()
STEPS: list[int] = printed_energy_errors().steps_per_period.values.tolist()


def _half_up(values: xr.DataArray, decimals: int) -> xr.DataArray:
    # a value within round-off of a half counts as a half
    return np.floor(values * 10**decimals + 0.5 + 1e-9) / 10**decimals


def once(values: xr.DataArray) -> xr.DataArray:
    """Values rounded to one decimal, halves up."""
    return _half_up(values, 1)


def twice(values: xr.DataArray) -> xr.DataArray:
    """Values rounded to two decimals and then to one, halves up."""
    return _half_up(_half_up(values, 2), 1)


def same(a: xr.DataArray, b: xr.DataArray | float) -> xr.DataArray:
    """Whether two arrays of rounded numbers have the same printed digits."""
    return abs(a - b) < 0.01
