"""Numbers of the text: the order of schemes under the circumstances of real problems."""

import xarray as xr

from paper.measures.orders import LOST
from paper.products import numbers
from paper.wording import joined
from study.words import listed, printed, span

#: Circumstances with kinks of the force, and smooth circumstances.
KINKED, SMOOTH = ["hysteresis", "contact"], ["plain", "damping", "load"]
#: Largest observed order that counts as first order, and largest that counts as second order.
ONE, TWO = 1.6, 2.5


@numbers(orders="order_under_reality", requires={"order_under_reality.schemes": ["generalized_alpha"]})
def observed_order_numbers(orders: xr.Dataset) -> dict:
    """Observed orders under the circumstances."""
    observed, data = orders.observed_order, {"orders": orders}
    displacement = observed.sel(quantity="displacement")
    kinked = displacement.sel(circumstance=KINKED)
    wrong, plain = (displacement.sel(circumstance=name) for name in ("inconsistent_start", "plain"))
    depends = orders.scheme.values[(plain - wrong > LOST).values]
    alpha = observed.sel(scheme="generalized_alpha", circumstance=SMOOTH)
    late, moved = (alpha.sel(quantity=name) for name in ("acceleration", "displacement"))
    meanings = orders.status.flag_meanings.split()
    loose = [name for name in orders.circumstance.values if name.startswith("tolerance_")]
    early = (plain - displacement.sel(circumstance=loose)).max()
    return {
        "reality_schemes": orders.sizes["scheme"],
        "reality_reaches_round_off": bool((orders.status == meanings.index("exact")).any()),
        "reality_kinks_highest": f"{float(kinked.max()):.1f}",
        "reality_kinks_take_all": bool(kinked.max() < TWO and displacement.sel(circumstance=SMOOTH).max() > TWO + 1),
        "reality_start": listed(
            (
                f"order {claimed} becomes {span(part, '.1f')} with {joined(part.scheme.values, data)}"
                for claimed, part in wrong.sel(scheme=depends).groupby("order")
            ),
            "; ",
        )
        if len(depends)
        else None,
        "reality_alpha_is_late": bool(late.max() < ONE and moved.min() > ONE),
        "reality_alpha": span(late, ".1f"),
        "reality_newton_loosest": printed(f"{orders.tolerance.max().item():.0e}"),
        "reality_newton_loss": f"{max(0.0, early.item()):.2f}",
    }
