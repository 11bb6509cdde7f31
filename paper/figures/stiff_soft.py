"""A mass on a stiff spring: velocity of the schemes where no step resolves the mode."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, looks
from paper.products import figure


@figure(
    "Velocity of a mass on a stiff spring.",
    history="structure_history/stiff_soft",
    asks={"structure_history.stiff_soft.problem": "stiff_soft"},
)
def draw(history: xr.Dataset) -> Figure:
    """One panel per scheme, over the reference at the same instants."""
    rows = -(-history.sizes["scheme"] // 2)
    figure, axes = plt.subplots(rows, 2, figsize=(PAGE, 0.24 * PAGE * rows), sharex=True, sharey=True, squeeze=False)
    for empty in axes.ravel()[history.sizes["scheme"] :]:
        empty.remove()
    styles = looks(history.scheme)
    for index, (ax, name) in enumerate(zip(axes.ravel(), history.scheme.values, strict=False)):
        one = history.sel(scheme=name)
        ax.plot(
            history.t_reference, history.reference_v.isel(component=0), ".", color="0.65", markersize=4, label="exact"
        )
        ax.plot(history.t, one.v.isel(component=0), **{**styles[name], "linestyle": "-", "markersize": 2})
        letter(ax, index, one.scheme_title.item())
    for ax in axes[-1]:
        ax.set_xlabel("time")
    for ax in axes[:, 0]:
        ax.set_ylabel("velocity of the\nfirst mass")
    axes[0, 0].legend(loc="upper right")
    return figure
