"""Order of schemes under the circumstances of real problems, one cell per scheme and circumstance."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.data import families
from paper.figures.style import PAGE, letter, panels
from paper.products import figure

#: Loss of order with the shade of a failure. Loss of order above which the text in a cell is white.
DARKEST, WHITE = 2.5, 1.3


def _draw(axes: Axes, orders: xr.Dataset) -> None:
    """Draw the orders of one quantity; a darker cell marks a larger loss of order."""
    loss = (orders.order - orders.observed_order).transpose("scheme", "circumstance").values
    status = np.array(orders.status.flag_meanings.split())[orders.status.transpose("scheme", "circumstance").values]
    shade = np.where(status == "failed", DARKEST, np.clip(np.nan_to_num(loss), 0.0, DARKEST))
    axes.imshow(shade, cmap="Greys", vmin=0, vmax=1.3 * DARKEST, aspect="auto")
    for (row, column), how in np.ndenumerate(status):
        order = orders.observed_order.transpose("scheme", "circumstance").values[row, column]
        number = "<0" if order < -0.05 else f"{abs(order):.1f}".removesuffix(".0")
        text = {"measured": number, "failed": "×", "exact": "∘"}.get(how, "")
        colour = "white" if shade[row, column] > WHITE else "black"
        axes.text(column, row, text, ha="center", va="center", color=colour)
    axes.set_xticks(range(orders.sizes["circumstance"]), orders.circumstance_title.values, rotation=90)
    axes.set_yticks(range(orders.sizes["scheme"]), orders.scheme_title.values)
    axes.set_xticks(np.arange(0.5, orders.sizes["circumstance"] - 1), minor=True)
    axes.set_yticks(np.arange(0.5, orders.sizes["scheme"] - 1), minor=True)
    axes.grid(which="minor", color="0.85", linewidth=0.4)
    axes.tick_params(which="both", length=0)
    axes.spines[:].set_visible(False)


@figure(
    "Observed order of displacement, velocity and acceleration under the circumstances of real problems. A darker "
    "cell marks a larger loss of the order of the scheme. Cross: no convergence, or an error of the size of the "
    "motion; circle: round-off; empty: the circumstance does not apply.",
    orders="order_under_reality",
)
def draw(orders: xr.Dataset) -> Figure:
    """One panel per quantity, one row per scheme by family, one column per circumstance."""
    orders = xr.concat(list(families(orders).values()), "scheme")
    figure, axes = panels(1, orders.sizes["quantity"], PAGE, 2.6 + 0.36 * orders.sizes["scheme"], sharey=True)
    for index, (ax, quantity) in enumerate(zip(axes[0], orders.quantity.values, strict=True)):
        _draw(ax, orders.sel(quantity=quantity))
        letter(ax, index, quantity)
    return figure
