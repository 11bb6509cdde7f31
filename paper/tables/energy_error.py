"""Tables 1 and 2 of the paper: as printed, computed with its step sizes, and computed with the exact periods."""

import pandas as pd
import xarray as xr

from paper.data import cells_of_tables
from paper.products import table
from paper.published import printed_energy_errors
from paper.requirements import REPRODUCED_TABLES


def _percent(error: float) -> str:
    """An error with two decimals, from which the printed decimal was rounded; below 0.01, one significant digit."""
    return f"{error:.2f}" if error >= 0.01 else f"{error:.1g}"


@table("Energy errors of Tables 1 and 2 of 1996", requires=REPRODUCED_TABLES)
def tabulate(energy_error: xr.Dataset) -> pd.DataFrame:
    """Three rows per problem and step size (printed, computed, exact period), one column per scheme of 1996."""
    printed = printed_energy_errors()
    energy_error = cells_of_tables(energy_error)
    ours = 100 * energy_error.max_energy_error
    sources = {
        "printed": printed,
        "computed": ours.sel(period_used="printed"),
        "exact period": ours.sel(period_used="exact"),
    }
    title_of = dict(zip(energy_error.problem.values, energy_error.problem_title.values, strict=True))
    rows = []
    for problem in energy_error.problem.values:
        for steps in energy_error.steps_per_period.values:
            for source, values in sources.items():
                row = {"Problem": title_of[problem], "Step": f"T/{steps}", "Source": source}
                for scheme in energy_error.scheme.values:
                    title = energy_error.scheme_title.sel(scheme=scheme).item()
                    error = values.sel(problem=problem, steps_per_period=steps, scheme=scheme).item()
                    row[title] = f"{error:.1f}" if source == "printed" else _percent(error)
                rows.append(row)
    return pd.DataFrame(rows)
