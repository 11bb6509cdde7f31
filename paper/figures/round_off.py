"""Error of very fine steps with plain and with compensated sums."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, legend_size, looks
from paper.products import figure


@figure("Error at very small steps, with plain and with compensated summation.", round_off="round_off")
def draw(round_off: xr.Dataset) -> Figure:
    """Error over steps per period, filled markers for plain and open ones for compensated sums."""
    figure, ax = plt.subplots(figsize=(0.8 * PAGE, 0.35 * PAGE))
    known = round_off.error.where(round_off.flagged == 0)
    ax.axhspan(0, 10 * round_off.uncertainty.item(), color="0.9", linewidth=0)
    for name, look in looks(round_off.scheme).items():
        run = known.sel(scheme=name)
        title = run.scheme_title.item()
        ax.plot(run.steps_per_period, run.sel(summation="plain"), label=title, **look)
        ax.plot(run.steps_per_period, run.sel(summation="compensated"), **{**look, "markerfacecolor": "white"})
    ax.set(xscale="log", yscale="log", xlabel="steps per period", ylabel=f"error after {round_off.periods:d}⅛ periods")
    figure.legend(loc="outside right center", fontsize=legend_size(round_off.sizes["scheme"], most=12))
    return figure
