"""Error of very fine steps with plain and with compensated sums."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, curve_styles, legend_below, panels
from paper.products import figure

#: Scheme that is left out; it is of first order, and far from round-off.
LEFT_OUT = "newmark_dissipative"


@figure(
    "Error of the displacement at very small steps, with plain sums (filled markers) and with compensated ones "
    "(open). Grey: ten times the uncertainty of the reference.",
)
def draw(round_off: xr.Dataset) -> Figure:
    """Error against steps per period: filled markers for plain sums, open markers for compensated sums."""
    round_off = round_off.drop_sel(scheme=LEFT_OUT, errors="ignore")
    figure, ((ax,),) = panels(1, 1, COLUMN, 7.5)
    known = round_off.end_error.where(round_off.flagged == 0)
    ax.axhspan(0, 10 * round_off.uncertainty.item(), color="0.85", linewidth=0)
    for name, look in curve_styles(round_off.scheme).items():
        run = known.sel(scheme=name)
        ax.plot(run.steps_per_period, run.sel(summation="plain"), label=run.scheme_title.item(), **look)
        hollow = look | {"markerfacecolor": "white", "markersize": 4.5, "zorder": 1.9}
        ax.plot(run.steps_per_period, run.sel(summation="compensated"), **hollow)
    ax.set(xscale="log", yscale="log", xlabel="steps per period", ylabel=f"error after {round_off.periods:d}⅛ periods")
    legend_below(figure, columns=3)
    return figure
