"""Numbers of the text: where schemes find the second tongue of Mathieu's equation."""

import xarray as xr

from paper.products import numbers
from paper.requirements import rising
from paper.terms import FAITHFUL


@numbers(
    requires={"mathieu.schemes": [*FAITHFUL, "hht_alpha"], "mathieu.steps_per_period": rising, "mathieu.tongues": 2}
)
def of_mathieu(mathieu: xr.Dataset) -> dict:
    """Shift of the second tongue at the coarsest step and the largest ε, and the ε up to which HHT-α closes it."""
    coarsest = mathieu.isel(steps_per_period=0, tongue=-1)
    middle, exact = (edge.isel(epsilon=-1).mean("side", skipna=False) for edge in (coarsest.edge, coarsest.exact_edge))
    shift = 100 * (middle / exact - 1)
    closed = coarsest.epsilon.where(coarsest.edge.sel(scheme="hht_alpha").isnull().any("side")).max().item()
    return {
        "tongue_steps": coarsest.steps_per_period.item(),
        "tongue_epsilon": f"{mathieu.epsilon.values[-1]:g}",
        "tongue_closed": f"{closed:g}" if closed > 0 else None,
        **{f"tongue_shift_{name}": f"{shift.sel(scheme=name).item():.1f}" for name in FAITHFUL},
    }
