"""Every scheme of the study by family: order, kind, memory, forces and source."""

import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table


def _forces(scheme: xr.Dataset) -> str:
    """Force evaluations per step as a text, such as k + 1, with the number k of Newton iterations."""
    fixed, per_iteration = scheme.force_evaluations_per_step.item(), scheme.force_evaluations_per_iteration.item()
    newton = f"{per_iteration} k" if per_iteration > 1 else "k"
    return " + ".join([newton] * (per_iteration > 0) + [str(fixed)] * (fixed > 0))


@table("All schemes")
def tabulate(spectral: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    rows = []
    for family, part in families(spectral).items():
        for name in part.scheme.values:
            scheme = part.sel(scheme=name)
            order, damped = scheme.order.item(), scheme.order_with_damping.item()
            rows.append(
                {
                    "Family": family,
                    "Scheme": scheme.scheme_title.item(),
                    "Order": str(order) if order == damped else f"{order} ({damped})",
                    "Kind": "explicit" if scheme.explicit else "implicit",
                    "Vectors": scheme.memory.item(),
                    "Forces": _forces(scheme),
                    "Source": scheme.scheme_source.item(),
                }
            )
    return pd.DataFrame(rows)
