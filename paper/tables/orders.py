"""Observed orders of the schemes of the paper in every measure of error."""

import pandas as pd
import xarray as xr

from paper.data import schemes_of_1996
from paper.measures.orders import PERIODS, order_at_finest
from paper.products import table
from paper.published import SCHEMES

_TITLES = {
    "displacement_error": "Trajectory",
    "rms_displacement_error": "rms",
    "phase_error": "Phase",
    "period_elongation": "Elongation",
    "amplitude_decay": "Amplitude",
    "max_energy_error": "Energy",
    "energy_drift": "at the end",
}


def _observed(run: xr.Dataset) -> dict[str, str]:
    """Orders of a scheme on a problem, one column per measure; a dash where no order can be fitted."""
    orders = {title: order_at_finest(run[measure].sel(periods=PERIODS[measure])) for measure, title in _TITLES.items()}
    named = {"Scheme": run.scheme_title.item(), "Order": str(run.order.item())}
    return named | {title: f"{order:.2f}" if order == order else "–" for title, order in orders.items()}


@table(
    "Orders of the schemes of 1996",
    requires={"accuracy.schemes": SCHEMES, "accuracy.periods": sorted(set(PERIODS.values()))},
)
def tabulate(accuracy: xr.Dataset) -> pd.DataFrame:
    """One row per problem and scheme."""
    accuracy = schemes_of_1996(accuracy)
    return pd.DataFrame(
        {
            "Problem": accuracy.problem_title.sel(problem=problem).item(),
            **_observed(accuracy.sel(problem=problem, scheme=scheme)),
        }
        for problem in accuracy.problem.values
        for scheme in accuracy.scheme.values
    )
