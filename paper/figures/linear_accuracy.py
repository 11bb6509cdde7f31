"""Period elongation and damping ratio of every scheme without physical damping, one column per family."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import curve_styles, figure_of_families, legend_in, thinned
from paper.products import figure

#: Largest Δt/T in the figure, as in textbooks.
TO = 0.4


@figure(
    "Period elongation (above) and algorithmic damping ratio (below) of every scheme on the linear oscillator, by "
    "family, as far as the scheme is stable.",
    requires={"spectral.damping_ratios": [0.0]},
)
def draw(spectral: xr.Dataset) -> Figure:
    """Elongation in percent (above) and algorithmic damping ratio in percent (below) against Δt/T, where stable."""
    data = spectral.sel(damping_ratio=0.0, step_size_over_period=slice(None, TO))
    stable = 2 * np.pi * data.step_size_over_period <= data.stability_limit
    elongation, damping = data.period_elongation.where(stable), data.algorithmic_damping.where(stable)
    figure, columns = figure_of_families(data, 2, 2.7)
    for part, (above, below, place_of_legend) in columns:
        for place, (name, look) in enumerate(curve_styles(part.scheme).items()):
            title = part.scheme_title.sel(scheme=name).item()
            for ax, percent in ((above, 100 * elongation.sel(scheme=name)), (below, 100 * damping.sel(scheme=name))):
                marked = (0.25 + 0.03 * place, 0.25) if percent.notnull().any() else None
                width = thinned(2.4, 0.25, place)
                ax.plot(data.step_size_over_period, percent, markevery=marked, **look, linewidth=width, label=title)
        above.set(ylim=(-30, 60))
        below.set(ylim=(-1, 20), xlabel="Δt/T")
        legend_in(place_of_legend, below)
    first_above, first_below, _ = columns[0][1]
    first_above.set_ylabel("period elongation (%)")
    first_below.set_ylabel("damping ratio (%)")
    return figure
