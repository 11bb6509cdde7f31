"""Steps per period that keep the energy of every scheme within 1, 5 and 10 percent at all amplitudes."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.products import table
from paper.requirements import rising


def _steps(value: float, most: int) -> str:
    return f"> {most}" if np.isnan(value) else f"{value:.0f}"


@table(
    "Steps in a period at all amplitudes", robustness="stability/robustness", requires={"robustness.periods": rising}
)
def tabulate(robustness: xr.Dataset) -> pd.DataFrame:
    """One row per scheme, one column per problem and level of the error, for the longest runs."""
    most = int(robustness.most_steps_per_period)
    rows = []
    for scheme in robustness.scheme.values:
        one = robustness.fewest_steps_per_period.sel(scheme=scheme).isel(periods=-1)
        row = {"Scheme": robustness.scheme_title.sel(scheme=scheme).item()}
        for problem, title in zip(robustness.problem.values, robustness.problem_title.values, strict=True):
            for level in robustness.allowed_error.values:
                needed = one.sel(problem=problem, allowed_error=level).item()
                row[f"{title.split()[0].capitalize()} {100 * level:g} %"] = _steps(needed, most)
        rows.append(row)
    return pd.DataFrame(rows)
