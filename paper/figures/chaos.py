"""Largest Lyapunov exponents, and contraction of volumes, of chaotic motions by scheme and step."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure

#: Schemes drawn.
SHOWN = ("average_acceleration", "central_difference", "newmark_dissipative", "rk4")
#: Number of standard errors of an interval.
ERRORS = 2


@figure(
    "Chaotic motions by scheme and step. Above: largest Lyapunov exponent, with two standard errors; below zero the "
    "motion is regular; grey: as printed. Below: rate at which volumes of states contract, over that of the motion. A "
    "point is missing where a run failed.",
)
def draw(chaos: xr.Dataset) -> Figure:
    """One column per problem."""
    problems = chaos.problem.values
    figure, axes = panels(2, len(problems), PAGE, 9.5, sharex=True)
    for column, name in enumerate(problems):
        motions = chaos.sel(problem=name)
        above, below = axes[:, column]
        for scheme, look in curve_styles(motions.scheme).items():
            if scheme in SHOWN:
                runs = motions.sel(scheme=scheme)
                largest, error = (runs[part].isel(place=0) for part in ("exponent", "uncertainty"))
                label = runs.scheme_title.item()
                above.errorbar(runs.steps_per_period, largest, ERRORS * error, label=label, elinewidth=0.8, **look)
                below.plot(runs.steps_per_period, runs.contraction / runs.damping, **look)
        above.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        if np.isfinite(motions.printed_exponent):
            above.axhline(motions.printed_exponent.item(), color="0.7", linewidth=1.5, zorder=0)
        below.axhline(1, color="0.6", linewidth=0.6, zorder=0)
        below.set_xlabel("steps in a period of the load")
        steps = motions.steps_per_period.values
        ticks = steps[:: -(-len(steps) // 5)]
        for ax in (above, below):
            ax.set(xscale="log")
            ax.set_xticks(ticks, [str(tick) for tick in ticks])
            ax.minorticks_off()
        low, high = below.get_ylim()
        if high > 2:
            below.set_yscale("log")
            ratios = [tick for tick in (0.2, 0.5, 1, 2, 5, 10) if low < tick < high]
            below.set_yticks(ratios, [f"{tick:g}" for tick in ratios])
            below.minorticks_off()
        letter(above, column, motions.problem_title.item())
        letter(below, column + len(problems), "contraction")
    axes[0, 0].set_ylabel("largest exponent (1/s)")
    axes[1, 0].set_ylabel("over that of the motion")
    legend_below(figure, columns=4)
    return figure
