"""Spectral radius of every scheme without damping, one panel per family."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import a_panel_for_each_family, legend_beside, looks, thinned
from paper.products import figure

#: Below this step size all spectral radii are one to the eye.
FROM = 0.02


@figure("Spectral radius of every scheme.", spectral="spectral", asks={"spectral.damping_ratios": [0.0]})
def draw(spectral: xr.Dataset) -> Figure:
    """ρ against Δt/T; the curves of explicit schemes leave the panel where they lose their stability."""
    data = spectral.sel(damping_ratio=0.0, dt_over_period=slice(FROM, None))
    figure, panels = a_panel_for_each_family(data, height=1.9, sharex=True, sharey=True)
    for ax, part in panels.items():
        for thickness, (name, look) in enumerate(looks(part.scheme).items()):
            run = part.sel(scheme=name)
            # thinner lines over thicker ones, so that coinciding curves are all visible
            ax.plot(
                run.dt_over_period,
                run.spectral_radius,
                label=run.scheme_title.item(),
                **look | {"marker": None, "linewidth": thinned(2.6, 0.28, thickness)},
            )
        ax.set(xscale="log", xlim=(FROM, 1e3), ylim=(0, 1.25))
        legend_beside(ax)
    for ax in figure.axes[-2:]:
        ax.set_xlabel("step size over period")
    for ax in figure.axes[::2]:
        ax.set_ylabel("spectral radius")
    return figure
