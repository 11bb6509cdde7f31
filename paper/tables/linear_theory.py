"""Linear theory of every scheme from its amplification matrix."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table

#: Δt/T at which the table gives elongation and damping. Δt/T at which it gives the overshoot.
FINE, COARSE = 1 / 20, 10.0
#: Factor above one within round-off; limits are rounded down.
EXACT = 1 + 1e-7


def _number(value: float, form: str) -> str:
    """A number as a text, without the sign of a negative zero; a dash if the number is not finite."""
    if not np.isfinite(value):
        return "–"
    text = format(value, form)
    return text.lstrip("-") if float(text) == 0 else text


@table("Linear theory", requires={"spectral.damping_ratios": [0.0]})
def tabulate(spectral: xr.Dataset) -> pd.DataFrame:
    """One row per scheme."""
    damped = spectral.damping_ratio.values.max()
    rows = []
    for part in families(spectral).values():
        for name in part.scheme.values:
            scheme = part.sel(scheme=name)
            free, resisted = scheme.sel(damping_ratio=0.0), scheme.sel(damping_ratio=damped)
            around = free.sel(step_size_over_period=slice(FINE / 2, 2 * FINE))
            fine = around.interp(step_size_over_period=FINE, method="cubic")
            coarse = free.sel(step_size_over_period=COARSE, method="nearest")
            limit = free.stability_limit.item()
            rows.append(
                {
                    "Scheme": scheme.scheme_title.item(),
                    "Order": f"{free.linear_order.item():.1f}",
                    f"ξ = {damped:g}": f"{resisted.linear_order.item():.1f}",
                    "Re-derived": _number(free.order_rederived.item(), ".1f"),
                    "Ω crit": "∞" if np.isinf(limit) else f"{np.floor(1000 * limit * EXACT) / 1000:.3f}",
                    "ρ∞": f"{free.infinite_frequency_radius.item():.2f}" if np.isinf(limit) else "–",
                    "Elongation %": _number(100 * fine.period_elongation.item(), ".3f"),
                    "Damping %": _number(100 * fine.algorithmic_damping.item(), ".3f"),
                    "Overshoot u": _number(coarse.displacement_overshoot.item(), ".1f"),
                    "Overshoot u̇": _number(coarse.velocity_overshoot.item(), ".1f"),
                }
            )
    return pd.DataFrame(rows)
