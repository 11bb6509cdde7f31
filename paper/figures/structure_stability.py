"""Lyapunov exponents of the numerical maps of structures, against the step size."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, legend_in_gap, letter, panels, wrapped
from paper.products import figure

#: Largest absolute value of an exponent in a panel with a linear scale.
LINEAR = 2.0
COLUMNS = 5


@figure(
    "Lyapunov exponents of the schemes on structures over the step size. A positive exponent means "
    "that neighbouring runs separate, because the structure is chaotic or only the scheme is.",
    structures="stability/structures",
    requires={"stability.structures.excitations": [1]},
)
def draw(structures: xr.Dataset) -> Figure:
    """One panel per structure."""
    structures = structures.sel(excitation=1)
    problems = structures.problem.values
    columns = min(len(problems), COLUMNS)
    rows = -(-len(problems) // columns)
    figure, axes = panels(rows, columns, PAGE, 3.9 * rows + 1.5)
    styles = curve_styles(structures.scheme)
    for index, (ax, problem) in enumerate(zip(axes.ravel(), problems, strict=False)):
        one = structures.sel(problem=problem)
        for scheme, style in styles.items():
            exponent = one.lyapunov_exponent.sel(scheme=scheme)
            ax.plot(one.steps_per_period, exponent, label=exponent.scheme_title.item(), **style)
        ax.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        ax.set(xscale="log")
        if np.nanmax(np.abs(one.lyapunov_exponent)) > LINEAR:
            ax.set_yscale("symlog", linthresh=1)
        steps = one.steps_per_period.values
        labelled = steps[:: -(-len(steps) // 4)]
        ax.set_xticks(labelled, [str(value) for value in labelled])
        ax.minorticks_off()
        letter(ax, index, wrapped(one.problem_title.item(), 14))
        if index + columns >= len(problems):
            ax.set_xlabel("steps in time scale")
    figure.supylabel("Lyapunov exponent × time scale", fontsize="medium")
    legend_in_gap(figure, axes, len(problems), columns=6)
    return figure
