"""Energy error over step sizes, and how runs fail at large steps."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from paper.asks import rising
from paper.data import of_the_paper
from paper.figures.style import PAGE, letter
from paper.products import figure
from paper.published import SCHEMES

#: Classes of the outcome: the better the lighter.
CLASSES = {
    "error below 1 %": "#f7f7f7",
    "below 10 %": "#c7dcef",
    "below 50 %": "#72b2d7",
    "above 50 %": "#E69F00",
    "damped away": "#2166ac",
    "Newton did not converge": "#b2182b",
    "not finite": "#000000",
}
_BOUNDS = [1, 10, 50]
_DAMPED, _FAILED = 4, 4


def classify(run: xr.Dataset) -> np.ndarray:
    """Index of the class of every run.

    A run is damped away if its error exceeds 50 % and at least nine tenths of it are a loss of energy at the end.
    """
    error, drift = run.max_energy_error, run.energy_drift
    completed = np.digitize(np.nan_to_num(error, nan=0.0), _BOUNDS)
    completed = np.where((error > _BOUNDS[-1]) & (-drift > 0.9 * error), _DAMPED, completed)
    return np.where(run.status == 0, completed, _FAILED + run.status)


@figure(
    "Energy error and failures over step size, by scheme and problem.",
    large_steps="large_steps",
    asks={"large_steps.schemes": SCHEMES, "large_steps.dt_over_period": rising("large_steps.dt_over_period")},
)
def draw(large_steps: xr.Dataset) -> Figure:
    """One panel per problem, one row per scheme of 1996."""
    large_steps = of_the_paper(large_steps)
    lines = -(-large_steps.sizes["problem"] // 2)
    figure, axes = plt.subplots(lines, 2, figsize=(PAGE, 0.31 * lines * PAGE), sharex=True, sharey=True, squeeze=False)
    for empty in axes.ravel()[large_steps.sizes["problem"] :]:
        empty.remove()
    parts = large_steps.dt_over_period.values
    edges = np.concatenate([[parts[0]], np.sqrt(parts[1:] * parts[:-1]), [parts[-1]]])
    colours = ListedColormap(list(CLASSES.values()))
    rows = np.arange(large_steps.sizes["scheme"] + 1) - 0.5
    for index, (ax, problem) in enumerate(zip(axes.ravel(), large_steps.problem.values, strict=False)):
        one = large_steps.sel(problem=problem)
        outcome = classify(one)
        ax.pcolormesh(
            edges, rows, outcome, cmap=colours, vmin=-0.5, vmax=len(CLASSES) - 0.5, edgecolors="white", linewidth=0.3
        )
        for part in (1 / 20, 1 / 5):
            ax.axvline(part, color="black", linewidth=0.8, linestyle="--")
        ax.set(xscale="log", yticks=rows[:-1] + 0.5, yticklabels=large_steps.scheme_title.values)
        ax.set_xticks([0.01, 0.05, 0.2, 0.5], ["1/100", "1/20", "1/5", "1/2"])
        ax.minorticks_off()
        letter(ax, index, one.problem_title.item())
    axes[0, 0].invert_yaxis()
    for ax in axes[-1]:
        ax.set_xlabel("step size over period")
    handles = [Patch(facecolor=colour, edgecolor="0.5", label=name) for name, colour in CLASSES.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure
