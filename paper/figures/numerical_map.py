"""Phase portraits of the numerical map: closed curves, islands and their break-up as the step grows."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE
from paper.products import figure


@figure("Phase portraits of the numerical map.", numerical_map="stability/numerical_map")
def draw(numerical_map: xr.Dataset) -> Figure:
    """One row per scheme, one column per step size, one colour per initial displacement."""
    schemes, steps = numerical_map.scheme.values, numerical_map.dt.values
    figure, axes = plt.subplots(
        len(schemes),
        len(steps),
        figsize=(PAGE, PAGE / len(steps) * len(schemes) * 0.95),
        sharex=True,
        sharey=True,
        squeeze=False,
    )
    colours = plt.get_cmap("viridis")(0.8 * numerical_map.u0 / numerical_map.u0.max())  # its yellow is lost on white
    for row, scheme in zip(axes, schemes, strict=True):
        for ax, dt in zip(row, steps, strict=True):
            for lane, colour in zip(numerical_map.u0.values, colours, strict=True):
                one = numerical_map.sel(scheme=scheme, dt=dt, u0=lane)
                ax.plot(one.u, one.v, ".", color=colour, markersize=0.7, markeredgewidth=0, rasterized=True)
            ax.set(xlim=(-2.2, 2.2), ylim=(-1.2, 1.2))
        row[0].set_ylabel(f"{numerical_map.scheme_title.sel(scheme=scheme).item()}\nvelocity")
    for ax, dt in zip(axes[0], steps, strict=True):
        ax.set_title(f"Δt = {dt:g}")
    for ax in axes[-1]:
        ax.set_xlabel("displacement")
    return figure
