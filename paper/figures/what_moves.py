"""What moves collapse intensity, drift and residual drift of a yielding mass with P-Δ."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles_in_order, legend_below, letter, panels
from paper.measures.what_moves import CHOSEN, QUANTITIES, SINGLE, choice_spread, median_changes, single_changes
from paper.products import figure

#: Smallest change in percent that is drawn; smaller ones are drawn there.
SMALLEST = 0.01


@figure(
    "Change of the median over records of collapse intensity, peak drift and residual drift of a yielding mass with "
    "P-Δ, by step, damping and strength, with 95 % intervals over the records; half of the 95 % interval of the median "
    f"over a choice of records; (d) the change of the peak drift that {100 * SINGLE:g} % of single records do not "
    "exceed, with its 95 % interval. A drift is missing where most motions collapse.",
)
def draw(what_moves: xr.Dataset) -> Figure:
    """A panel for each median, and one for single records; a row for each variant, a marker for each period."""
    variants = [name for name in what_moves.variant.values if name != "reference"]
    titles = [what_moves.variant_title.sel(variant=name).item() for name in variants]
    rows = [*titles, *(f"choice of {count} records" for count in CHOSEN)]
    figure, (axes,) = panels(1, 4, PAGE, 6.6, sharey=True)
    looks = curve_styles_in_order(f"{period:g} s" for period in what_moves.period.values)
    shifts = np.linspace(-0.25, 0.25, len(looks))
    for index, (ax, (name, title)) in enumerate(zip(axes, QUANTITIES.items(), strict=False)):
        medians = 100 * median_changes(what_moves[name]).sel(variant=variants)
        for p, ((label, look), shift) in enumerate(zip(looks.items(), shifts, strict=True)):
            changes = medians.isel(period=p)
            # the interval of the size of a change whose interval contains zero begins at zero
            crosses = (changes.low <= 0) & (changes.high >= 0)
            inner = np.minimum(abs(changes.low), abs(changes.high)).where(~crosses, SMALLEST)
            outer = np.maximum(abs(changes.low), abs(changes.high))
            style = {"color": look["color"], "marker": look["marker"]}
            _sizes(ax, shift, abs(changes.change), inner, outer, label=f"period {label}", **style)
            choices = [100 * choice_spread(what_moves[name], count).isel(period=p).item() for count in CHOSEN]
            ax.plot(choices, len(variants) + np.arange(len(CHOSEN)) + shift, linestyle="", markersize=3.5, **style)
        letter(ax, index, title)
    last = axes[-1]
    single = 100 * single_changes(what_moves.peak_drift).sel(variant=variants)
    for p, ((_, look), shift) in enumerate(zip(looks.items(), shifts, strict=True)):
        changes = single.isel(period=p)
        _sizes(last, shift, changes.change, changes.low, changes.high, color=look["color"], marker=look["marker"])
    letter(last, len(QUANTITIES), "single drifts")
    for ax in axes:
        ax.set(xscale="log", xlim=(SMALLEST / 1.5, 400), xlabel="change (%)")
        ax.set_xticks([0.01, 0.1, 1, 10, 100], ["0.01", "0.1", "1", "10", "100"])
        ax.axhline(len(variants) - 0.5, color="0.8", linewidth=0.8)
    axes[0].set_yticks(range(len(rows)), rows)
    axes[0].invert_yaxis()
    legend_below(figure, columns=4)
    return figure


def _sizes(ax: Axes, shift: float, size: xr.DataArray, inner: xr.DataArray, outer: xr.DataArray, **look: Any) -> None:
    """A marker for the size of each change, and a line from the inner to the outer end of its interval."""
    place = np.arange(len(size)) + shift
    ax.hlines(place, inner.clip(SMALLEST), outer.clip(SMALLEST), color=look["color"], linewidth=0.9)
    ax.plot(size.clip(SMALLEST), place, linestyle="", markersize=3.5, **look)
