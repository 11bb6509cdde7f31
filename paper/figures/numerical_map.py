"""Phase portraits of the numerical map: closed curves, islands and their break-up as the step grows."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, panels, wrapped
from paper.products import figure


@figure(
    "Points of runs from many initial displacements in the double well, one shade each: closed curves where the "
    "scheme is regular, islands and scattered points where it is chaotic, as the step grows.",
    numerical_map="stability/numerical_map",
)
def draw(numerical_map: xr.Dataset) -> Figure:
    """One row per scheme, one column per step size, one colour per initial displacement."""
    schemes, steps = numerical_map.scheme.values, numerical_map.step_size.values
    figure, axes = panels(len(schemes), len(steps), PAGE, 2.0 * len(schemes) + 1.5, sharex=True, sharey=True)
    colours = plt.get_cmap("viridis")(0.8 * numerical_map.u0 / numerical_map.u0.max())  # yellow is invisible on white
    for row, scheme in zip(axes, schemes, strict=True):
        for ax, dt in zip(row, steps, strict=True):
            for lane, colour in zip(numerical_map.u0.values, colours, strict=True):
                one = numerical_map.sel(scheme=scheme, step_size=dt, u0=lane)
                ax.plot(one.u, one.v, ".", color=colour, markersize=1.2, markeredgewidth=0, rasterized=True)
            ax.set(xlim=(-2.2, 2.2), ylim=(-1.2, 1.2))
        row[0].set_ylabel(wrapped(numerical_map.scheme_title.sel(scheme=scheme).item(), 14))
    for ax, dt in zip(axes[0], steps, strict=True):
        ax.set_title(f"Δt = {dt:g} s")
    figure.supxlabel("displacement $u$", fontsize="medium")
    figure.supylabel("velocity $\\dot u$ (1/s)", fontsize="medium")
    return figure
