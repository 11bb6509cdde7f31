"""Error against the step size: on a smooth spring, with yielding, memory and contact, and under a ground motion."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.data import with_schemes
from paper.figures.style import PAGE, curve_styles, legend_in_gap, letter, panels, wrapped
from paper.products import figure

#: Schemes in the figure: of second and of fourth order.
SHOWN = ["average_acceleration", "central_difference", "rk4", "yoshida4"]
COLUMNS = 5


@figure(
    "Error of the displacement against the step on a smooth spring, with yielding, memory and contact, and "
    "under a record. Markers without a line: steps that divide the spacing of the record. "
    "Grey lines are proportional to the first and to the second power of the step.",
)
def draw(kinks: xr.Dataset) -> Figure:
    """One panel per problem; grey lines are proportional to the first and to the second power of the step."""
    kinks = with_schemes(kinks, SHOWN)
    number = kinks.sizes["problem"]
    columns = min(number, COLUMNS)
    rows = -(-number // columns)
    figure, axes = panels(rows, columns, PAGE, 5.2 * rows + 1, sharex=True)
    steps = kinks.steps_per_period
    for index, (ax, problem) in enumerate(zip(axes.flat, kinks.problem.values, strict=False)):
        runs = kinks.sel(problem=problem)
        worst = float(runs.sampled_error.isel(steps_per_period=0).max())
        for power in (1, 2):
            ax.plot(steps, worst * (steps[0] / steps) ** power, color="0.8", linestyle="-", linewidth=2.5, zorder=0)
        for name, look in curve_styles(kinks.scheme).items():
            error = runs.sampled_error.sel(scheme=name)
            if np.isfinite(error).any():
                ax.plot(steps, error, label=error.scheme_title.item(), **look)
            if np.isfinite(dividing := runs.dividing_sampled_error.sel(scheme=name)).any():
                numbers = runs.time_scale / runs.spacing * runs.steps_per_spacing
                ax.plot(numbers, dividing, **look | {"linestyle": ""})
        ax.set(xscale="log", yscale="log")
        ax.xaxis.set_minor_formatter(NullFormatter())
        letter(ax, index, wrapped(runs.problem_title.item(), 12))
        if index + columns >= number:
            ax.set_xlabel("steps per period")
            ax.tick_params(labelbottom=True)
    for ax in axes[:, 0]:
        ax.set_ylabel("error of the displacement\nover its size")
    legend_in_gap(figure, axes, number, columns=5)
    return figure
