"""The fastest scheme for an allowed error, by every measure of error, and its steps per period."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.tables.decision import AT_MOST, MEASURES


def _cell(needs: xr.Dataset) -> str:
    """The fastest scheme with its steps, and an asterisk if another ties with it."""
    name = needs.cheapest_scheme.item()
    if not name:
        return "–"
    best = needs.sel(scheme=name)
    at_most = AT_MOST if best.steps_per_period == needs.coarsest else ""
    tied = (needs.ties_with_fastest == 1).sum() > 1
    return f"{best.scheme_title.item()}: {at_most}{best.steps_per_period.item():,.0f}{' *' if tied else ''}"


@table(asks={"recommendation.measures": list(MEASURES)})
def tabulate(recommendation: xr.Dataset) -> pd.DataFrame:
    """One row per problem, length of the run and error; a dash where no scheme keeps the error."""
    titles = dict(zip(recommendation.problem.values, recommendation.problem_title.values, strict=True))
    rows = []
    for problem, title in titles.items():
        for periods in recommendation.periods.values:
            for error in recommendation.error.values:
                # by a mapping: a problem's error is a coordinate here, and xarray has methods of such names
                needs = recommendation.sel({"problem": problem, "error": error, "periods": periods})
                row = {
                    "Problem": title[0].upper() + title[1:],
                    "Periods": f"{periods:,}",
                    "Error": f"{100 * error:g} %" if error > 1e-5 else f"{error:g}",
                }
                rows.append(
                    row | {what.capitalize(): _cell(needs.sel({"measure": name})) for name, what in MEASURES.items()}
                )
    return pd.DataFrame(rows)
