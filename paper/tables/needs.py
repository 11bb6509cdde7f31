"""Cost of accuracy with every scheme: steps in a period and computing time for an error of the displacement."""

import pandas as pd
import xarray as xr

from paper.data import steps_of_period
from paper.products import table
from paper.requirements import OF_THE_ASSESSMENTS
from study.analysis.recommendation import recommend


@table("Steps and time for an error", spring="assessment/hardening", requires=OF_THE_ASSESSMENTS)
def tabulate(spring: xr.Dataset) -> pd.DataFrame:
    """One row per scheme, one column per error; a dash where no step keeps the error."""
    rows = []
    tables = {
        f"{100 * error:g} %": recommend(spring, error=error, quantity="displacement")
        for error in spring.allowed_error.values
    }
    for name, title in zip(spring.scheme.values, spring.scheme_title.values, strict=True):
        row = {"Scheme": title, "Kind": spring.kind.sel(scheme=name).item()}
        for error, needs in tables.items():
            step, time = needs.step_size[name], needs.time[name]
            row[error] = f"{steps_of_period(spring, step):,}, {1e3 * time:.2g} ms" if step > 0 else "–"
        rows.append(row)
    return pd.DataFrame(rows)
