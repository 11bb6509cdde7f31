"""How the numbers of 1996 were rounded: our value less the printed one, for all 98 cells."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import OF_THE_TABLES
from paper.data import of_the_tables
from paper.figures.style import PAGE, letter, looks
from paper.products import figure
from paper.published import printed_energy_errors


@figure(
    "Computed errors minus printed ones, for all cells of the tables of 1996.",
    energy_error="energy_error",
    asks=OF_THE_TABLES,
)
def draw(energy_error: xr.Dataset) -> Figure:
    """One panel for the step sizes of the printed periods, one for those of the exact periods."""
    figure, axes = plt.subplots(1, 2, figsize=(PAGE, 0.42 * PAGE), sharex=True)
    printed = printed_energy_errors()
    energy_error = of_the_tables(energy_error)
    for index, (ax, used) in enumerate(zip(axes, ("printed", "exact"), strict=True)):
        difference = energy_error.max_energy_error.sel(period_used=used) - printed
        for name, look in looks(energy_error.scheme).items():
            one = difference.sel(scheme=name)
            x, y = printed.sel(scheme=name).values.ravel(), one.values.ravel()
            look = {key: look[key] for key in ("color", "marker")}
            ax.plot(np.maximum(x, 0.05), y, linestyle="none", label=one.scheme_title.item(), alpha=0.8, **look)
        ax.axhspan(-0.05, 0.05, color="0.9", zorder=0)
        ax.set(xscale="log", xlabel="printed error (%), 0.0 drawn at 0.05")
        letter(ax, index, f"step sizes from the {used} periods")
    axes[0].set_ylim(-0.11, 0.11)
    axes[1].set_yscale("symlog", linthresh=0.1)
    axes[1].set_ylim(-3, 12)
    axes[0].set_ylabel("ours less printed (percentage points)")
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure
