"""Measured and predicted errors of steps under records of several spacings and spectra."""

import numpy as np
import xarray as xr

#: Scheme of the law.
SCHEME = "average_acceleration"
#: Percentiles of the range that holds 95 % of the runs.
RANGE = (2.5, 97.5)
#: Largest scatter in decades of errors that lie on one curve.
ONE_CURVE = 0.15


def predicted(errors: xr.Dataset) -> xr.DataArray:
    """Predicted error of the displacement."""
    return np.hypot(errors.of_period, errors.of_load)


def scatter(errors: xr.Dataset, predictor: xr.DataArray) -> float:
    """Standard deviation of log₁₀ of the measured error about a straight line in log₁₀ of a predictor."""
    error, by = xr.broadcast(errors.error.sel(load="samples"), predictor)
    known = (error > 0) & (by > 0)
    x, y = (np.log10(values.values[known.values]) for values in (by, error))
    return float(np.std(y - np.polyval(np.polyfit(x, y, 1), x)))


def order(errors: xr.Dataset, load: str, divides: bool) -> float:
    """Median order, over oscillators and records, of the error at steps up to the spacing that divide it or not."""
    some = errors.isel(ratio=((errors.divides == divides) & (errors.ratio <= 1)).values).sel(load=load)
    x, y = (np.log(values) for values in xr.broadcast(some.step_size.where(some.error > 0), some.error))
    x, y = x - x.mean("ratio"), y - y.mean("ratio")
    return float(((x * y).sum("ratio") / (x**2).sum("ratio")).where(x.notnull().sum("ratio") > 2).median())


def over_period(errors: xr.Dataset, load: str) -> float:
    """97.5th percentile of measured error over predicted error of the period, at steps that do not divide."""
    off = errors.sel(scheme=SCHEME).isel(ratio=(errors.divides == 0).values)
    return float(np.nanpercentile(off.error.sel(load=load) / off.of_period, RANGE[1]))


def share_of_runs(kept: xr.DataArray) -> tuple[float, float, float]:
    """Share of the runs, over (record, ...), that keep a bound, and the ends of its 95 % interval over the records.

    The runs under one record are not independent, so Student's interval is that of the mean over the records. ``kept``
    is NaN where there is no run.
    """
    from scipy.stats import t as student  # here, as few products need it

    share, of_records = kept.mean().item(), kept.mean([name for name in kept.dims if name != "record"]).values
    half = student.ppf(0.975, len(of_records) - 1) * of_records.std(ddof=1) / np.sqrt(len(of_records))
    return share, max(share - half, 0.0), min(share + half, 1.0)
