"""Errors of energy and phase over very long times, and their round-off."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure

#: Label of each quantity.
_LABELS = {"energy": "energy", "phase": "phase (periods)"}
#: Exponent with which round-off grows in time, with its label: for random errors (Brouwer's law), and for a drift.
_RANDOM, _DRIFTING = {"energy": (0.5, "½"), "phase": (1.5, "3/2")}, {"energy": (1.0, "1"), "phase": (2.0, "2")}


def _guide(ax: Axes, round_off: xr.DataArray, offset: float, law: tuple[float, str]) -> None:
    """Draw a line with the slope of a law over the last part of the runs.

    The line ends at ``offset`` times the final round-off of a scheme: the largest if ``offset`` exceeds one, and the
    smallest otherwise.
    """
    exponent, label = law
    x = round_off.periods.values[round_off.periods.values >= round_off.periods.values[-1] / 50]
    last = round_off.isel(periods=-1)
    end = offset * (last.max() if offset > 1 else last.min()).item()
    ax.plot(x, end * (x / x[-1]) ** exponent, color="0.6", linestyle="-", linewidth=0.8)
    ax.annotate(label, (x[-1], end), xytext=(4, 0), textcoords="offset points", color="0.4", va="center")


@figure(
    "Errors of energy and phase over long times. Above, in double precision: the error (filled markers) and its "
    "round-off part (open). Below, round-off in single precision: plain sums (filled) and compensated sums "
    "with a step size of few digits (open). Grey lines have the slopes of a random walk and of a drift.",
)
def draw(long_times: xr.Dataset) -> Figure:
    """Errors and round-off in double precision (above), and round-off in single precision (below)."""
    figure, axes = panels(2, 2, PAGE, 10.5, sharex=True)
    double = long_times.sel(arithmetic="float64", step="any")
    single = long_times.sel(arithmetic="float32", step="any")
    steady = long_times.sel(arithmetic="float32_compensated", step="short")
    errors = {"energy": double.max_energy_error, "phase": abs(double.phase_error)}
    for name, look in curve_styles(long_times.scheme).items():
        hollow = look | {"markerfacecolor": "white"}
        for (kind, error), (above, below) in zip(errors.items(), axes.T, strict=True):
            round_off = f"{kind}_round_off"
            title = error.sel(scheme=name).scheme_title.item()
            above.plot(long_times.periods, error.sel(scheme=name), label=title, **look)
            above.plot(long_times.periods, double[round_off].sel(scheme=name), **hollow)
            below.plot(long_times.periods, single[round_off].sel(scheme=name), **look)
            below.plot(long_times.periods, steady[round_off].sel(scheme=name), **hollow)
    for column, (kind, label) in enumerate(_LABELS.items()):
        above, below = axes[:, column]
        round_off = f"{kind}_round_off"
        _guide(above, double[round_off], 0.1, _RANDOM[kind])
        _guide(below, single[round_off], 3, _DRIFTING[kind])
        _guide(below, steady[round_off], 0.3, _RANDOM[kind])
        letter(above, column, f"{kind}, double precision")
        letter(below, column + 2, f"{kind}, round-off in single precision")
        for ax in (above, below):
            ax.set(xscale="log", yscale="log", ylabel=label)
        below.set_xlabel("elapsed periods")
    legend_below(figure, columns=5)
    return figure
