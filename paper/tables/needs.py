"""Cost of accuracy with every scheme: steps and, in brackets, forces in a period for an error of the displacement."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.tables.decision import column, forces_of, steps_of


@table("Steps and forces for an error", requires={"runs.problems.hardening.decided": lambda periods: ""})
def tabulate(needs: xr.Dataset) -> pd.DataFrame:
    """One row per scheme, one column per error, on the hardening spring; a dash where no step keeps the error."""
    spring = needs.sel(problem="hardening", quantity="displacement", condition="practice")
    rows = []
    for name in spring.scheme.values:
        one = spring.sel(scheme=name)
        at = {column(error): one.sel(allowed_error=error) for error in one.allowed_error.values}
        cells = {name: f"{steps_of(x)} ({forces_of(x)})" if x.step_size > 0 else "–" for name, x in at.items()}
        kind = "explicit" if one.explicit == 1 else "implicit"
        rows.append({"Scheme": one.scheme_title.item(), "Kind": kind, **cells})
    return pd.DataFrame(rows)
