"""Cost at one percent of error against the dissipation of high frequencies, a panel for each problem."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels, wrapped
from paper.products import figure
from paper.respects import costs

#: Abscissae of the schemes with the lowest and the highest finite stability limit, and the maximum number of panels in
#: a row.
LIMITED, MOST = (1.3, 1.8), 5


@figure(
    "Forces per period for one percent error of the displacement, against the spectral radius at infinite frequency. "
    "Schemes with a stability limit are to the right of the line, in the order of that limit. Bars at the top: no step "
    "that was tried reaches this error.",
)
def draw(needs: xr.Dataset, spectral: xr.Dataset) -> Figure:
    """One panel per problem, one marker per scheme."""
    forces = costs(needs)
    free = spectral.sel(damping_ratio=0, scheme=forces.scheme.values)
    limited = free.stability_limit[np.isfinite(free.stability_limit)].sortby(free.stability_limit).scheme.values
    places = dict(zip(limited, np.linspace(*LIMITED, len(limited)), strict=True))
    number = forces.sizes["problem"]
    rows = -(-number // MOST)
    columns = -(-number // rows)
    figure, axes = panels(rows, columns, PAGE, 3.8 * rows + 2.2, sharex=True, sharey=True)
    for unused in axes.flat[number:]:
        unused.remove()
    highest = 2 * float(forces.max())
    for index, (ax, problem) in enumerate(zip(axes.flat, forces.problem.values, strict=False)):
        for name, look in curve_styles(forces.scheme).items():
            cost = float(forces.sel(problem=problem, scheme=name))
            at = places.get(name, free.infinite_frequency_radius.sel(scheme=name).item())
            found = np.isfinite(cost)
            ax.plot(at, cost if found else highest, look["marker"] if found else "_", color=look["color"])
        ax.axvline((1 + LIMITED[0]) / 2, color="0.7", linestyle="-", linewidth=0.6)
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(NullFormatter())
        ax.set_xticks([0, 0.5, 1, sum(LIMITED) / 2], ["0", "0.5", "1", "limit"])
        letter(ax, index, wrapped(forces.problem_title.sel(problem=problem).item(), 13))
        if index + columns >= number:
            ax.set_xlabel("ρ∞")
            ax.tick_params(labelbottom=True)
    for ax in axes[:, 0]:
        ax.set_ylabel("evaluations per period")
    handles = [
        Line2D([], [], linestyle="", marker=look["marker"], color=look["color"], label=str(title))
        for look, title in zip(curve_styles(forces.scheme).values(), forces.scheme_title.values, strict=True)
    ]
    legend_below(figure, columns=4, handles=handles)
    return figure
