"""Outcome of runs of structures over step size and excitation."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.outcome_map import IMAGE, patches
from paper.figures.style import PAGE, legend_below, panels, wrapped
from paper.products import figure


@figure(
    "Outcome of runs of structures over step size and excitation, the factor of initial velocity and load; a cell "
    "is a run.",
    structures="stability/structures",
)
def draw(structures: xr.Dataset) -> Figure:
    """One row per structure, one column per scheme; a cell is a run."""
    problems, schemes = structures.problem.values, structures.scheme.values
    steps, excitations = structures.steps_per_period.values, structures.excitation.values
    height = 0.95 * len(problems) + 2.6
    figure, axes = panels(len(problems), len(schemes), PAGE, height, sharex=True, sharey=True)
    for row, problem in zip(axes, problems, strict=True):
        for ax, scheme in zip(row, schemes, strict=True):
            one = structures.outcome.sel(problem=problem, scheme=scheme)
            ax.imshow(one, **IMAGE)
        title = wrapped(structures.problem_title.sel(problem=problem).item(), 10)
        row[0].set_ylabel(title, rotation=0, ha="right", va="center")
    # a row has room for two labels
    ends = sorted({0, len(excitations) - 1})
    axes[0, 0].set_yticks(ends, [f"{excitations[place]:g}" for place in ends])
    for ax, title in zip(axes[0], structures.scheme_title.values, strict=True):
        ax.set_title(wrapped(title, 14))
    places = np.arange(len(steps))[:: -(-len(steps) // 4)]
    for ax in axes[-1]:
        ax.set_xticks(places, steps[places])
        ax.set_xlabel("steps")
    figure.supylabel("factor of the excitation", fontsize="medium")
    legend_below(figure, columns=4, handles=patches(structures.outcome.values, best="energy kept"))
    return figure
