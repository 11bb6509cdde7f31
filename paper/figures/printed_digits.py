"""Our values minus the printed values for all 98 cells of Tables 1 and 2, and the differences due to rounding."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import of_the_tables
from paper.figures.style import COLUMN, curve_styles, legend_below, letter, panels
from paper.products import figure
from paper.published import printed_energy_errors
from paper.requirements import OF_THE_TABLES


@figure(
    "Computed energy errors minus those printed in Tables 1 and 2 of Xie (1996), for all cells. Points in the grey "
    "band round to the printed digit. Printed errors of 0.0 are drawn at 0.05.",
    requires=OF_THE_TABLES,
)
def draw(energy_error: xr.Dataset) -> Figure:
    """One panel with step sizes from the printed periods, and one with step sizes from the exact periods."""
    figure, axes = panels(2, 1, COLUMN, 10.5, sharex=True)
    printed = printed_energy_errors()
    energy_error = of_the_tables(energy_error)
    for index, (ax, used) in enumerate(zip(axes.flat, ("printed", "exact"), strict=True)):
        difference = energy_error.max_energy_error.sel(period_used=used) - printed
        for name, look in curve_styles(energy_error.scheme).items():
            one = difference.sel(scheme=name)
            x, y = printed.sel(scheme=name).values.ravel(), one.values.ravel()
            look = {key: look[key] for key in ("color", "marker")}
            ax.plot(np.maximum(x, 0.05), y, linestyle="none", label=one.scheme_title.item(), markersize=3.5, **look)
        ax.axhspan(-0.05, 0.05, color="0.88", zorder=0)
        ax.set(xscale="log", ylabel="computed minus printed\n(percentage points)")
        letter(ax, index, f"step sizes from the {used} periods")
    axes[0, 0].set_ylim(-0.11, 0.11)
    axes[1, 0].set_yscale("symlog", linthresh=0.1)
    axes[1, 0].set_ylim(-3, 12)
    axes[1, 0].set_xlabel("printed error (%)")
    legend_below(figure, columns=3)
    return figure
