"""Error against the step on forces that are smooth, yield, remember and touch, and under a record."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, looks
from paper.products import figure


@figure("Error against the step where forces have kinks or remember.", kinks="kinks")
def draw(kinks: xr.Dataset) -> Figure:
    """One panel per problem; grey lines fall with the first and the second power of the step."""
    columns = 3
    rows = -(-kinks.sizes["problem"] // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(PAGE, rows * 0.33 * PAGE), sharex=True, squeeze=False)
    steps = kinks.steps_per_period
    for index, (ax, problem) in enumerate(zip(axes.flat, kinks.problem.values, strict=False)):
        of_problem = kinks.sel(problem=problem)
        worst = float(of_problem.error.isel(steps_per_period=0).max())
        for power in (1, 2):
            ax.plot(steps, worst * (steps[0] / steps) ** power, color="0.8", linewidth=2.5, zorder=0)
        for name, look in looks(kinks.scheme).items():
            error = of_problem.error.sel(scheme=name)
            if np.isfinite(error).any():
                ax.plot(steps, error, label=error.scheme_title.item(), **look)
        ax.set(xscale="log", yscale="log")
        letter(ax, index, of_problem.problem_title.item())
    for ax in axes[:, 0]:
        ax.set_ylabel("error of the displacement")
    for ax in axes.flat[kinks.sizes["problem"] :]:
        ax.remove()
    for ax in axes.flat[max(kinks.sizes["problem"] - columns, 0) : kinks.sizes["problem"]]:
        ax.set_xlabel("steps per period")
        ax.tick_params(labelbottom=True)
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=5)
    return figure
