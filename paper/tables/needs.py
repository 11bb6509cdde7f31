"""Cost of accuracy with every scheme: steps per period and time for an error of the displacement."""

import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table

PROBLEM, MEASURE, PERIODS = "hardening", "max_trajectory_error", 100


@table(
    asks={
        "recommendation.problems": [PROBLEM],
        "recommendation.measures": [MEASURE],
        "recommendation.periods": [PERIODS],
    },
)
def tabulate(recommendation: xr.Dataset) -> pd.DataFrame:
    """One row per scheme, one column per error; a dash where no step size of the study keeps it."""
    needs = recommendation.sel({"problem": PROBLEM, "measure": MEASURE, "periods": PERIODS})
    rows = []
    for part in families(needs).values():
        for name in part.scheme.values:
            scheme = part.sel(scheme=name)
            row = {"Scheme": scheme.scheme_title.item()}
            for error in part.error.values:
                # by a mapping: error is a coordinate here
                one = scheme.sel({"error": error})
                steps, time = one.steps_per_period.item(), one.time.item()
                title = f"{100 * error:g} %" if error > 1e-5 else f"{error:g}"
                at_most = "≤ " if steps == needs.coarsest else ""
                row[title] = f"{at_most}{steps:,.0f}, {1e3 * time:.2g} ms" if steps == steps else "–"
            rows.append(row)
    return pd.DataFrame(rows)
