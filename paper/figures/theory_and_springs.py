"""Period elongation and loss of amplitude by linear theory and on the springs, one row per scheme."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import families
from paper.figures.style import PAGE, legend_below, letter, panels
from paper.products import figure
from paper.requirements import contained

#: Number of steps per period, and number of periods, of the runs that are shown.
STEPS, PERIODS = 64, 3
MEASURES = {"period_elongation": "period elongation", "amplitude_decay": "loss of amplitude per period"}
PROBLEMS = {"hardening": ("s", "#0072B2"), "softening": ("^", "#D55E00")}
#: Smallest size drawn, near the left edge of the axes; smaller sizes are drawn at this value.
LEAST = 1e-10


def _points(ax, values, rows, label, **look) -> None:
    """Draw absolute values, with open markers for negative values and filled markers otherwise."""
    known = np.isfinite(values)
    size = np.maximum(np.abs(values[known]), LEAST)
    negative = values[known] < -LEAST
    filled = [look["color"] if not below else "white" for below in negative]
    ax.scatter(size, rows[known], s=13, marker=look["marker"], edgecolors=look["color"], facecolors=filled, zorder=3,
               linewidths=0.8, label=label)  # fmt: skip


@figure(
    f"Size of the period elongation and of the loss of amplitude at {STEPS} steps per period by linear theory and "
    f"in runs of {PERIODS} periods. Open markers: negative values. Smaller sizes are drawn at the left edge.",
    requires={
        "": contained("accuracy.schemes", within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "accuracy.steps_per_period": [STEPS],
        "accuracy.periods": [PERIODS],
        "accuracy.problems": list(PROBLEMS),
    },
)
def draw(spectral: xr.Dataset, accuracy: xr.Dataset) -> Figure:
    """Sizes of elongation (left) and of loss of amplitude (right) at one step size, on logarithmic axes."""
    schemes = [name for part in families(accuracy).values() for name in part.scheme.values]
    linear = spectral.sel(scheme=schemes, damping_ratio=0.0).interp(step_size_over_period=1 / STEPS)
    measured = accuracy.sel(scheme=schemes, steps_per_period=STEPS, periods=PERIODS)
    rows = np.arange(len(schemes))
    figure, ((left, right),) = panels(1, 2, PAGE, 2 + 0.28 * len(schemes), sharey=True)
    axes = (left, right)
    for index, (ax, (measure, title)) in enumerate(zip(axes, MEASURES.items(), strict=True)):
        _points(ax, linear[measure].values, rows, "linear theory", marker="o", color="0.45")
        for problem, (marker, colour) in PROBLEMS.items():
            run = measured.sel(problem=problem)
            _points(ax, run[measure].values, rows, run.problem_title.item(), marker=marker, color=colour)
        ax.set(xscale="log", xlim=(LEAST / 2, 2), yticks=rows, yticklabels=measured.scheme_title.values)
        ax.set_xlabel(f"size at {STEPS} steps per period")
        ax.grid(axis="y", color="0.9", linewidth=0.6)
        ax.set_axisbelow(True)
        letter(ax, index, title)
    boundaries = np.flatnonzero(measured.family.values[1:] != measured.family.values[:-1]) + 0.5
    for ax in axes:
        for boundary in boundaries:
            ax.axhline(boundary, color="0.4", linewidth=0.6)
    left.set_ylim(len(schemes) - 0.5, -0.5)
    legend_below(figure, columns=3)
    return figure
