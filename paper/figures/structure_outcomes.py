"""Outcome of runs of structures over step size and excitation."""

import textwrap

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.outcome_map import IMAGE, patches
from paper.figures.style import PAGE
from paper.products import figure


@figure("Outcome of runs of structures over step size and excitation.", structures="stability/structures")
def draw(structures: xr.Dataset) -> Figure:
    """One row per structure, one column per scheme; a cell is a run."""
    problems, schemes = structures.problem.values, structures.scheme.values
    steps, excitations = structures.steps_per_period.values, structures.excitation.values
    figure, axes = plt.subplots(
        len(problems),
        len(schemes),
        figsize=(PAGE, 0.85 * len(problems) + 0.7),
        sharex=True,
        sharey=True,
        squeeze=False,
    )
    for row, problem in zip(axes, problems, strict=True):
        for ax, scheme in zip(row, schemes, strict=True):
            one = structures.outcome.sel(problem=problem, scheme=scheme)
            ax.imshow(one, **IMAGE)
        row[0].set_ylabel(textwrap.fill(structures.problem_title.sel(problem=problem).item(), 13))
    axes[0, 0].set_yticks(np.arange(len(excitations)), [f"{factor:g}" for factor in excitations])
    for ax, title in zip(axes[0], structures.scheme_title.values, strict=True):
        ax.set_title(title.replace(" ", "\n", 1), fontsize=7)
    for ax in axes[-1]:
        ax.set_xticks(np.arange(len(steps))[::3], steps[::3])
        ax.set_xlabel("steps")
    figure.legend(handles=patches(structures.outcome.values), loc="outside lower center", ncols=6)
    return figure
