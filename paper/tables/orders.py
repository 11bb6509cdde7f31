"""Observed order of every scheme in every measure of error."""

import pandas as pd
import xarray as xr

from paper.orders import PERIODS, observed_order
from paper.tables.writing import main

_TITLES = {
    "max_trajectory_error": "Trajectory",
    "rms_trajectory_error": "rms",
    "phase_error": "Phase",
    "period_elongation": "Elongation",
    "amplitude_decay": "Amplitude",
    "max_energy_error": "Energy",
    "energy_drift": "at the end",
}


def tabulate(accuracy: xr.Dataset) -> pd.DataFrame:
    """One row a problem and scheme, a column a measure; a dash where no order can be fitted."""
    rows = []
    for problem in accuracy.problem.values:
        for scheme in accuracy.scheme.values:
            run = accuracy.sel(problem=problem, scheme=scheme)
            row = {"Problem": problem, "Scheme": run.scheme_title.item(), "Order": str(run.order.item())}
            for measure, title in _TITLES.items():
                order = observed_order(run[measure].sel(periods=PERIODS[measure]))
                row[title] = f"{order:.2f}" if order == order else "–"
            rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main(tabulate)
