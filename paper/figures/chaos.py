"""Largest Lyapunov exponents and mean squares of chaotic motions by scheme and step."""

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
    "motion is regular; grey: as printed. Below: difference of the mean square from that of the Runge-Kutta method at "
    "the finest step, with two standard errors; hollow: some runs are regular; grey: two standard errors of that mean "
    "square, and a line of second order. A point is missing where a run failed.",
)
def draw(chaos: xr.Dataset) -> Figure:
    """One column per problem."""
    problems = chaos.problem.values
    figure, axes = panels(2, len(problems), PAGE, 9.5, sharex=True)
    for column, name in enumerate(problems):
        motions = chaos.sel(problem=name)
        exact = motions.sel(scheme="rk4").isel(steps_per_period=-1)
        above, below = axes[:, column]
        steps = motions.steps_per_period
        for scheme, look in curve_styles(motions.scheme).items():
            if scheme in SHOWN:
                runs = motions.sel(scheme=scheme)
                largest, error = (
                    runs[part].isel(place=0) for part in ("lyapunov_exponent", "lyapunov_exponent_uncertainty")
                )
                label = runs.scheme_title.item()
                above.errorbar(steps, largest, ERRORS * error, label=label, elinewidth=0.8, **look)
                apart = abs(runs.mean_square / exact.mean_square - 1)
                spread = ERRORS * runs.mean_square_uncertainty / exact.mean_square
                below.errorbar(steps, apart.where(apart > 0), spread, elinewidth=0.8, **look)
                hollow = apart.where((apart > 0) & (runs.regular > 0))
                below.plot(steps, hollow, **look | {"linestyle": "none", "markerfacecolor": "white"}, zorder=3)
        above.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        if np.isfinite(motions.printed_exponent):
            above.axhline(motions.printed_exponent.item(), color="0.7", linewidth=1.5, zorder=0)
        uncertain = (ERRORS * exact.mean_square_uncertainty / exact.mean_square).item()
        below.axhline(uncertain, color="0.7", linewidth=1.5, zorder=0)
        below.plot(steps, (steps / steps[0]) ** -2.0, color="0.6", linewidth=0.6, zorder=0)
        below.set(yscale="log", ylim=(uncertain / 5, 3), xlabel="steps in a period of the load")
        ticks = steps.values[:: -(-len(steps) // 5)]
        for ax in (above, below):
            ax.set(xscale="log")
            ax.set_xticks(ticks, [str(tick) for tick in ticks])
            ax.minorticks_off()
        letter(above, column, motions.problem_title.item())
        letter(below, column + len(problems), "mean square")
    axes[0, 0].set_ylabel("largest exponent (1/s)")
    axes[1, 0].set_ylabel("difference, relative")
    legend_below(figure, columns=4)
    return figure
