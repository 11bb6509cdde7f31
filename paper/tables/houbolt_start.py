"""Houbolt's method with each way to start it: the error in one cell, and the number of cells reproduced."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.published import PROBLEMS, STEPS, once, printed_energy_errors, same, twice


@table(
    "Starts of the Houbolt method",
    requires={"houbolt_start.problems": PROBLEMS, "houbolt_start.steps_per_period": STEPS},
)
def tabulate(houbolt_start: xr.Dataset) -> pd.DataFrame:
    """One row per way to start the method."""
    error = 100 * houbolt_start.max_energy_error.sel(problem=PROBLEMS, steps_per_period=STEPS)
    printed = printed_energy_errors().sel(scheme="houbolt")
    return pd.DataFrame(
        {
            "Start": "Taylor polynomial" if ours.start == "taylor" else ours.start.item().replace("_", " "),
            "Hardening, T/20 (printed 97.3)": f"{ours.sel(problem='hardening', steps_per_period=20).item():.4f}",
            "Digits met, rounded once": f"{int(same(once(ours), printed).sum())} of {ours.size}",
            "Digits met, rounded twice": f"{int(same(twice(ours), printed).sum())} of {ours.size}",
        }
        for ours in error.transpose("start", ...)
    )
