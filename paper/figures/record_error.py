"""Errors of steps under records, against the power of the record above 1/(4Δt) and against the prediction."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from paper.figures.style import PAGE, legend_below, letter, panels
from paper.measures.record_error import SCHEME
from paper.products import figure

#: Colour, marker and label of steps that divide the spacing of the record, and of others.
KINDS: dict[int, dict[str, Any]] = {
    1: {"color": "#000000", "marker": "s", "label": "steps that divide the spacing"},
    0: {"color": "#56B4E9", "marker": "o", "label": "other steps"},
}


@figure(
    "Error of the displacement of linear oscillators under records with average acceleration, over the peak: against "
    "(a) the power of the record above 1/(4Δt), (b) the error predicted from the record. (c) The load is the mean of "
    "the record over each step; against the predicted error of the period alone.",
    errors="record_error",
    requires={"record_error.schemes": [SCHEME]},
)
def draw(errors: xr.Dataset) -> Figure:
    """Three panels with one point for each record, oscillator and step."""
    runs = errors.sel(scheme=SCHEME)
    figure, (axes,) = panels(1, 3, PAGE, 6.2)
    by = [runs.power_above, runs.predicted_error, runs.period_error]
    titles = ["power above $1/(4\\Delta t)$", "prediction", "mean load over a step"]
    labels = ["root of the share of the power", "predicted error", "predicted error of the period"]
    for index, (ax, predictor, title, label) in enumerate(zip(axes, by, titles, labels, strict=True)):
        error = runs.error.sel(load="averages" if index == 2 else "samples")
        for divides, look in reversed(KINDS.items()):
            kept = (runs.divides == divides).values
            x, y = (some.isel(ratio=kept).values for some in xr.broadcast(predictor, error))
            ax.plot(x.ravel(), y.ravel(), linestyle="", markersize=1.8, markeredgewidth=0, **look)
        if index:
            ends = [float(predictor.min()), float(predictor.max())]
            ax.plot(ends, ends, color="0.4", linestyle="-", linewidth=0.9, label="measured as predicted")
        ax.set(xscale="log", yscale="log", xlabel=label)
        letter(ax, index, title)
    axes[0].set(ylabel="measured error over the peak", xlim=(1e-4, 1.5))
    largest = float(np.nanmax(runs.error)) * 3
    for ax in axes:
        ax.set_ylim(1e-5, largest)
        ax.label_outer()
    handles = [Line2D([], [], linestyle="", markersize=4, **look) for look in KINDS.values()]
    legend_below(figure, columns=3, handles=[*handles, axes[1].get_lines()[-1]])
    return figure
