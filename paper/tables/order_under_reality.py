"""Circumstances under which each scheme loses its order."""

import pandas as pd
import xarray as xr

from paper.data import families
from paper.measures.orders import lost
from paper.products import table


def _titles(flags: xr.DataArray) -> str:
    """Titles of the circumstances that are flagged, or a dash."""
    return ", ".join(flags.circumstance_title.values[flags.values]) or "–"


@table("Loss of order by circumstance", orders="order_under_reality")
def tabulate(orders: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    rows = []
    for part in families(orders).values():
        for name in part.scheme.values:
            scheme = lost(part).sel(scheme=name)
            motion = scheme.sel(quantity=["displacement", "velocity"]).any("quantity")
            acceleration = scheme.sel(quantity="acceleration") & ~motion
            apart = part.status.sel(scheme=name) == part.status.flag_meanings.split().index("does_not_apply")
            rows.append(
                {
                    "Scheme": part.scheme_title.sel(scheme=name).item(),
                    "Order": str(part.order.sel(scheme=name).item()),
                    "Displacement or velocity": _titles(motion),
                    "Acceleration only": _titles(acceleration),
                    "Does not apply": _titles(apart.all("quantity")),
                }
            )
    return pd.DataFrame(rows)
