"""The answer: for an error that may be made, the cheapest scheme and its steps per period."""

import pandas as pd
import xarray as xr

from paper.tables.writing import main

MEASURE = "max_trajectory_error"


def tabulate(recommendation: xr.Dataset, work_precision: xr.Dataset) -> pd.DataFrame:
    """One row a problem and error, a column a length of the run; a dash where no scheme keeps the error."""
    titles = dict(zip(work_precision.scheme.values, work_precision.scheme_title.values, strict=True))
    best = recommendation.sel(measure=MEASURE)
    rows = []
    for problem in best.problem.values:
        for error in best.error.values:
            row = {"Problem": problem, "Error": f"{100 * error:g} %" if error > 1e-5 else f"{error:g}"}
            for periods in best.periods.values:
                # by a mapping: a problem's error is a coordinate here, and xarray has methods of such names
                one = best.sel({"problem": problem, "error": error, "periods": periods})
                scheme = one.cheapest_scheme.item()
                row[f"{periods} periods"] = f"{titles[scheme]}, {one.steps_per_period.item():.0f}" if scheme else "–"
            rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main(tabulate)
