"""Observed order of every scheme in every measure of error, on one spring."""

import pandas as pd
import xarray as xr

from paper.data import families
from paper.orders import PERIODS
from paper.products import table
from paper.tables.orders import observed

PROBLEM = "softening"


@table(accuracy="accuracy", asks={"accuracy.problems": [PROBLEM], "accuracy.periods": sorted(set(PERIODS.values()))})
def tabulate(accuracy: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    parts = families(accuracy.sel(problem=PROBLEM)).values()
    return pd.DataFrame(observed(part.sel(scheme=name)) for part in parts for name in part.scheme.values)
