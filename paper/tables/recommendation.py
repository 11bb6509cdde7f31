"""The cheapest scheme for an allowed error, and its steps per period."""

import pandas as pd
import xarray as xr

from paper.products import table

MEASURE = "max_trajectory_error"


@table(recommendation="recommendation", asks={"recommendation.measures": [MEASURE]})
def tabulate(recommendation: xr.Dataset) -> pd.DataFrame:
    """One row per problem and error, one column per length of the run; a dash where no scheme keeps the error."""
    needs = recommendation.sel(measure=MEASURE)
    rows = []
    for problem in needs.problem.values:
        for error in needs.error.values:
            row = {"Problem": problem, "Error": f"{100 * error:g} %" if error > 1e-5 else f"{error:g}"}
            for periods in needs.periods.values:
                # by a mapping: a problem's error is a coordinate here, and xarray has methods of such names
                one = needs.sel({"problem": problem, "error": error, "periods": periods})
                name = one.cheapest_scheme.item()
                best = one.sel(scheme=name) if name else None
                needed = f"{best.scheme_title.item()}, {best.steps_per_period.item():.0f}" if best is not None else "–"
                row[f"{periods} periods"] = needed
            rows.append(row)
    return pd.DataFrame(rows)
