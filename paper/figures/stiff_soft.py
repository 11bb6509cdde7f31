"""Velocity of a mass on a stiff spring, by schemes whose steps do not resolve its oscillation."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, curve_styles, letter, panels
from paper.products import figure


@figure(
    "Velocity of a mass on a stiff spring whose oscillation no step resolves, at the steps of each scheme, over "
    "the exact one (grey) at the instants of the reference.",
    history="structure_history/stiff_soft",
    requires={"structure_history.stiff_soft.problem": "stiff_soft"},
)
def draw(history: xr.Dataset) -> Figure:
    """One panel per scheme: its velocity, drawn over the reference in grey."""
    rows = history.sizes["scheme"]
    figure, axes = panels(rows, 1, COLUMN, 2.3 * rows + 0.8, sharex=True, sharey=True)
    styles = curve_styles(history.scheme)
    for index, (ax, name) in enumerate(zip(axes.flat, history.scheme.values, strict=True)):
        run = history.sel(scheme=name)
        exact, v = history.reference_v.isel(component=0), run.v.isel(component=0)
        ax.plot(history.t_reference, exact, "o", color="0.7", markersize=5, label="exact")
        ax.plot(history.t, v, label="scheme", **styles[name] | {"linestyle": "-", "linewidth": 0.7, "markersize": 2.5})
        letter(ax, index, run.scheme_title.item())
    axes[-1, 0].set_xlabel("elapsed time $t$ (s)")
    figure.supylabel("velocity of the first mass (m/s)", fontsize="medium")
    return figure
