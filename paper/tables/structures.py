"""The schemes on structures at one step size: error of the displacement and of the balance of energies."""

import pandas as pd
import xarray as xr

from paper.figures.structures import BEYOND, SHOWN
from paper.products import table

STEPS_PER_PERIOD = 80
#: Variables of the errors, and their labels in the table.
ERRORS = {"displacement_error": "displacement", "max_energy_imbalance": "energy"}


def _percent(value: float) -> str:
    if not value <= 100 * BEYOND:
        return "≫"
    if value < 0.001:
        return "<0.001"
    return f"{value:.2g}" if value < 99.5 else f"{value:,.0f}"


def _cell(run: xr.Dataset, error: str) -> str:
    """An error in percent, or the kind of failure. The step of a failure depends on round-off and is not shown."""
    if run.status != 0:
        return "N" if run.status == 1 else "∞"
    return _percent(100 * run[error].item())


@table("Errors on structures", requires={"structures.steps_per_period": [STEPS_PER_PERIOD]})
def tabulate(structures: xr.Dataset) -> pd.DataFrame:
    """Two rows per structure, one for each error, and one column per scheme."""
    at = structures.sel(steps_per_period=STEPS_PER_PERIOD)
    shown = [name for name in SHOWN if name in at.scheme.values]
    rows = []
    for problem in at.problem.values:
        one = at.sel(problem=problem)
        title = one.problem_title.item()
        facts = {
            "Structure": title[0].upper() + title[1:],
            "Unknowns": f"{one.unknowns.item():.0f}",
            "Scale": f"{one.period.item():.3g}",
            "Length": f"{one.periods.item() * one.period.item():.3g}",
        }
        for error, name in ERRORS.items():
            cells = {one.scheme_title.sel(scheme=n).item(): _cell(one.sel(scheme=n), error) for n in shown}
            rows.append(facts | {"Error": name} | cells)
            facts = dict.fromkeys(facts, "")
    return pd.DataFrame(rows)
