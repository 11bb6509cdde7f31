"""How round-off of the energy grows, by scheme, arithmetic and step size."""

import pandas as pd
import xarray as xr

from paper.products import table

#: Arithmetic and step size of each column.
COLUMNS = {
    "Double": ("float64", "any"),
    "Single": ("float32", "any"),
    "Single, compensated": ("float32_compensated", "any"),
    "Single, short step": ("float32", "short"),
    "Single, short step, compensated": ("float32_compensated", "short"),
}


def _cell(one: xr.Dataset) -> str:
    """Exponent of the growth with its standard error, and final round-off in percent; or the step of a failure."""
    last = one.isel(periods=-1)
    if last.status != 0:
        return f"fails at step {last.failed_at_step.item():,}"
    law = one.sel(quantity="energy_round_off")
    return f"{law.exponent.item():.2f} ± {law.exponent_error.item():.2f}, {100 * last.energy_round_off.item():.0e}"


@table("Growth of round-off")
def tabulate(long_times: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    return pd.DataFrame(
        {"Scheme": scheme.scheme_title.item()}
        | {title: _cell(scheme.sel(arithmetic=a, step=s)) for title, (a, s) in COLUMNS.items()}
        for scheme in (long_times.sel(scheme=name) for name in long_times.scheme.values)
    )
