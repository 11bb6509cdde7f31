"""Error of the displacement of structures against the step size."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import with_schemes
from paper.figures.style import PAGE, curve_styles, legend_in_gap, letter, panels
from paper.products import figure

#: Schemes in the figure: explicit and implicit, with and without numerical damping.
SHOWN = [
    "average_acceleration",
    "central_difference",
    "bathe",
    "implicit_midpoint",
    "energy_momentum",
    "gauss4",
]
COLUMNS = 4
#: Largest error, relative to the displacement, that the limits of a panel include.
BEYOND = 100


@figure(
    "Largest error of the displacement of structures, relative to its largest size, against the step size. A point is "
    "missing where a run failed. Grey: uncertainty of the reference.",
)
def draw(structures: xr.Dataset) -> Figure:
    """One panel per structure; a failed run leaves a gap."""
    shown = with_schemes(structures, SHOWN)
    number = shown.sizes["problem"]
    columns = min(number, COLUMNS)
    rows = -(-number // columns)
    figure, axes = panels(rows, columns, PAGE, 3.3 * rows + 1.5, sharex=True)
    for index, (ax, problem) in enumerate(zip(axes.ravel(), shown.problem.values, strict=False)):
        runs = shown.sel(problem=problem)
        for name, look in curve_styles(shown.scheme).items():
            error = runs.sampled_displacement_error.sel(scheme=name)
            # no line joins the points if there are only two
            line = look if error.sizes["steps_per_period"] > 2 else look | {"linestyle": "none", "markersize": 5}
            ax.plot(runs.steps_per_period, error, label=error.scheme_title.item(), **line)
        ax.axhline(runs.displacement_uncertainty.item(), color="0.7", linewidth=1.5, zorder=0)
        ax.set(xscale="log", yscale="log")
        steps = runs.steps_per_period.values
        labelled = steps[:: -(-len(steps) // 3)]
        ax.set_xticks(labelled, [f"{n:g}" for n in labelled])
        ax.minorticks_off()
        ax.margins(x=0.1)
        seen = runs.sampled_displacement_error.where(runs.sampled_displacement_error < BEYOND)
        if seen.notnull().any():
            ax.set_ylim(seen.min() / 3, 3 * seen.max())
        letter(ax, index, runs.problem_title.item())
        if index + columns >= number:
            ax.set_xlabel("steps in the time scale")
            ax.tick_params(labelbottom=True)
    figure.supylabel("largest error of the displacement", fontsize="medium")
    legend_in_gap(figure, axes, number, columns=4)
    return figure
