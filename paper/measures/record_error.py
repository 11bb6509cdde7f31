"""Measured and predicted errors of steps under records of several spacings and spectra."""

import numpy as np
import xarray as xr

#: Scheme of the law.
SCHEME = "average_acceleration"
#: Percentiles of the range that holds 95 % of the runs.
RANGE = (2.5, 97.5)
#: Largest scatter in decades of errors that lie on one curve.
ONE_CURVE = 0.15


def scatter(errors: xr.Dataset, predictor: xr.DataArray) -> float:
    """Standard deviation of log₁₀ of the measured error about a straight line in log₁₀ of a predictor."""
    error, by = xr.broadcast(errors.error.sel(load="samples"), predictor)
    known = (error > 0) & (by > 0)
    x, y = (np.log10(values.values[known.values]) for values in (by, error))
    return float(np.std(y - np.polyval(np.polyfit(x, y, 1), x)))


def square_of_step(errors: xr.Dataset) -> xr.DataArray:
    """(ωΔt)², with the circular frequency ω of the oscillator."""
    return (2 * np.pi * errors.step_size / errors.period) ** 2


def order(errors: xr.Dataset, load: str, divides: bool) -> float:
    """Median order, over oscillators and records, of the error at steps up to the spacing that divide it or not."""
    some = errors.isel(ratio=((errors.divides == divides) & (errors.ratio <= 1)).values).sel(load=load)
    x, y = (np.log(values) for values in xr.broadcast(some.step_size.where(some.error > 0), some.error))
    x, y = x - x.mean("ratio"), y - y.mean("ratio")
    return float(((x * y).sum("ratio") / (x**2).sum("ratio")).where(x.notnull().sum("ratio") > 2).median())


def over_period(errors: xr.Dataset, load: str) -> float:
    """97.5th percentile of measured error over predicted error of the period, at steps that do not divide."""
    off = errors.sel(scheme=SCHEME).isel(ratio=(errors.divides == 0).values)
    return float(np.nanpercentile(off.error.sel(load=load) / off.period_error, RANGE[1]))
