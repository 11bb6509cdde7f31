"""Shares of runs under records, with intervals over the records: the runs under one record are not independent."""

import numpy as np
import xarray as xr

from paper.wording import share_with


def share_of_runs(kept: xr.DataArray) -> tuple[float, float, float]:
    """Share of the runs, over (record, ...), that keep a bound, and the ends of its 95 % interval over the records.

    The interval is Clopper and Pearson's for the number of records if no record has both outcomes, and otherwise
    Student's of the mean over the records. ``kept`` is NaN where there is no run.
    """
    from scipy.stats import binomtest  # here, as few products need it
    from scipy.stats import t as student

    share, record_shares = kept.mean().item(), kept.mean([name for name in kept.dims if name != "record"]).values
    if np.isin(record_shares, [0, 1]).all():
        low, high = binomtest(int(record_shares.sum()), len(record_shares)).proportion_ci(0.95, method="exact")
        return share, low, high
    number = len(record_shares)
    half = student.ppf(0.975, number - 1) * record_shares.std(ddof=1) / np.sqrt(number) if number > 1 else np.inf
    return share, max(share - half, 0.0), min(share + half, 1.0)


def with_interval(beyond: xr.DataArray) -> str:
    """A share of the runs, over (record, ...), in percent with its interval of 95 % confidence over the records."""
    return share_with(*share_of_runs(beyond))
