"""Spectral radius of every scheme without damping, one panel per family."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import curve_styles, figure_of_families, legend_in, thinned
from paper.products import figure

#: Δt/T below which all spectral radii look like 1.
FROM = 0.02


@figure(
    "Spectral radius of every scheme on the undamped linear oscillator, by family. A scheme is unstable where the "
    "radius exceeds one. Where the radius is small, it removes modes that the step does not resolve.",
    requires={"spectral.damping_ratios": [0.0]},
)
def draw(spectral: xr.Dataset) -> Figure:
    """ρ against Δt/T; a scheme is unstable where its curve exceeds one."""
    data = spectral.sel(damping_ratio=0.0, step_size_over_period=slice(FROM, None))
    figure, columns = figure_of_families(data, 1, 3.0)
    for part, (ax, below) in columns:
        for place, (name, look) in enumerate(curve_styles(part.scheme).items()):
            run = part.sel(scheme=name)
            # thinner lines over thicker ones, so that coinciding curves are all visible
            look = look | {"linewidth": thinned(2.6, 0.28, place), "markevery": (10 + 15 * place, 120)}
            ax.plot(run.step_size_over_period, run.spectral_radius, label=run.scheme_title.item(), **look)
        ax.set(xscale="log", xlim=(FROM, 1e3), ylim=(0, 1.25), xlabel="Δt/T")
        ax.set_xticks([0.1, 10, 1000], ["0.1", "10", "1000"])
        legend_in(below, ax)
    figure.axes[0].set_ylabel("spectral radius")
    return figure
