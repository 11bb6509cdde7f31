"""Four measures of error against the step size."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import of_the_paper
from paper.figures.style import PAGE, letter, looks
from paper.products import figure
from paper.published import SCHEMES

MEASURES = {
    "max_trajectory_error": "largest error of $u$",
    "phase_error": "size of delay (periods)",
    "amplitude_decay": "change of amplitude",
    "max_energy_error": "energy error (%)",
}
PROBLEMS = ("hardening", "softening")


@figure(
    "Errors of displacement, phase, amplitude and energy against step size.",
    accuracy="accuracy",
    asks={"accuracy.schemes": SCHEMES, "accuracy.problems": list(PROBLEMS), "accuracy.periods": [100]},
)
def draw(accuracy: xr.Dataset) -> Figure:
    """One row per problem, one column per measure, over 100 periods; errors within the reference's own are left out."""
    accuracy = of_the_paper(accuracy).sel(periods=100)
    figure, axes = plt.subplots(len(PROBLEMS), len(MEASURES), figsize=(PAGE, 0.62 * PAGE), sharex=True, sharey="col")
    for row, problem in zip(axes, PROBLEMS, strict=True):
        for ax, (measure, label) in zip(row, MEASURES.items(), strict=True):
            for name, look in looks(accuracy.scheme).items():
                run = accuracy.sel(problem=problem, scheme=name)
                size = abs(run[measure]).where(run.flagged.sel(measure=measure) == 0)
                ax.plot(run.steps_per_period, size, label=run.scheme_title.item(), markevery=2, **look)
            ax.set(xscale="log", yscale="log")
            ax.set_xticks([10, 100, 1000])
            if ax in axes[-1]:
                ax.set_xlabel("steps per period")
            letter(ax, int(np.flatnonzero(axes.ravel() == ax)[0]), label)
        row[0].set_ylabel(accuracy.problem_title.sel(problem=problem).item())
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure
