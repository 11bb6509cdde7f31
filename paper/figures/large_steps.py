"""Energy error against the step size, and how runs fail at large steps."""

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from paper.data import schemes_of_1996
from paper.figures.outcome_map import LIMIT
from paper.figures.style import PAGE, legend_below, letter, panels
from paper.products import figure
from paper.published import SCHEMES
from paper.requirements import rising

#: Colour of each class of outcomes. Worse outcomes are darker, and all colours differ in greyscale.
CLASSES = {
    "error below 1 %": "#ffffff",
    "below 10 %": "#cbdff2",
    "below 50 %": "#8dbcde",
    "above 50 %": "#cc8c11",
    "damped away": "#1c679e",
    "no solution found": "#4b1c70",
    "unbounded": "#000000",
}
_BOUNDS = [0.01, 0.1, 0.5]
_DAMPED, _FAILED = 4, 4


def classify(run: xr.Dataset) -> np.ndarray:
    """Index of the class of every run.

    A completed run is damped away if its error exceeds 50 % and the energy that it has lost by the end exceeds nine
    tenths of this error.
    """
    error, drift = run.max_energy_error, run.energy_drift
    completed = np.digitize(np.nan_to_num(error, nan=0.0), _BOUNDS)
    completed = np.where((error > _BOUNDS[-1]) & (-drift > 0.9 * error), _DAMPED, completed)
    unsolved = run.status == run.status.flag_meanings.split().index("no_solution_found")
    return np.where(run.status == 0, completed, np.where(unsolved, _FAILED + 1, _FAILED + 2))


@figure(
    "Largest energy error over 100 periods, or the failure, of every scheme of 1996 over the step size; T is the "
    "rounded period that Xie (1996) prints. Dashed lines: the step T/20 that he finds reasonable for two of them, and "
    "T/5, above which he expects failures.",
    requires={"large_steps.schemes": SCHEMES, "large_steps.step_size_over_period": rising},
)
def draw(large_steps: xr.Dataset) -> Figure:
    """One panel per problem, one row per scheme of 1996."""
    large_steps = schemes_of_1996(large_steps)
    lines = -(-large_steps.sizes["problem"] // 2)
    figure, axes = panels(lines, 2, PAGE, 4 * lines + 1.5, sharex=True, sharey=True)
    for unused in axes.ravel()[large_steps.sizes["problem"] :]:
        unused.remove()
    parts = large_steps.step_size_over_period.values
    edges = np.concatenate([[parts[0]], np.sqrt(parts[1:] * parts[:-1]), [parts[-1]]])
    colours = ListedColormap(list(CLASSES.values()))
    rows = np.arange(large_steps.sizes["scheme"] + 1) - 0.5
    for index, (ax, problem) in enumerate(zip(axes.ravel(), large_steps.problem.values, strict=False)):
        runs = large_steps.sel(problem=problem)
        outcome = classify(runs)
        ax.pcolormesh(
            edges, rows, outcome, cmap=colours, vmin=-0.5, vmax=len(CLASSES) - 0.5, edgecolors="0.6", linewidth=0.2
        )
        for part in (1 / 20, 1 / 5):
            ax.axvline(part, **LIMIT)
        ax.set(xscale="log", yticks=rows[:-1] + 0.5, yticklabels=large_steps.scheme_title.values)
        ax.set_xticks([0.01, 0.05, 0.2, 0.5], ["1/100", "1/20", "1/5", "1/2"])
        ax.minorticks_off()
        letter(ax, index, runs.problem_title.item())
    axes[0, 0].invert_yaxis()
    for ax in axes[-1]:
        ax.set_xlabel("step size over period, Δt/T")
    handles = [Patch(facecolor=colour, edgecolor="0.5", label=name) for name, colour in CLASSES.items()]
    legend_below(figure, columns=4, handles=handles)
    return figure
