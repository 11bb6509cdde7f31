"""The cells of Tables 1 and 2 that do not round to the printed digit, each with its reason."""

import pandas as pd
import xarray as xr

from paper.data import cells_of_tables
from paper.products import table
from paper.published import once, printed_energy_errors, same, twice
from paper.requirements import REPRODUCED_TABLES

_ROUNDED_TWICE = "rounded to two decimals, then to one"
_UNEXPLAINED = "by no rounding rule; see the text"


@table("Cells that differ from the printed digit", requires=REPRODUCED_TABLES)
def tabulate(energy_error: xr.Dataset) -> pd.DataFrame:
    """One row per cell whose value, rounded once, is not the printed value."""
    printed = printed_energy_errors()
    ours = 100 * cells_of_tables(energy_error).max_energy_error.sel(period_used="printed")
    rows = []
    for problem in ours.problem.values:
        for steps in ours.steps_per_period.values:
            for scheme in ours.scheme.values:
                cell = {"problem": problem, "steps_per_period": steps, "scheme": scheme}
                value, digit = ours.sel(cell), printed.sel(cell)
                if same(once(value), digit):
                    continue
                rows.append(
                    {
                        "Problem": value.problem_title.item(),
                        "Step": f"T/{steps}",
                        "Scheme": value.scheme_title.item(),
                        "Printed": f"{digit.item():.1f}",
                        "Computed": f"{value.item():.4f}",
                        "To two decimals": f"{value.item():.2f}",
                        "Explained": _ROUNDED_TWICE if same(twice(value), digit) else _UNEXPLAINED,
                    }
                )
    return pd.DataFrame(rows)
