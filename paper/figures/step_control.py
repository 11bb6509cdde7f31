"""Ratios of estimates to true errors; energy errors and final errors with controlled and with equal steps."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.figures.style import PAGE, curve_styles_in_order, letter, panels
from paper.measures.step_control import PROBLEM, SCHEME
from paper.products import figure

#: Smallest ratio of estimate to true error that is shown; the closed form of the ratio is zero at turning points.
LEAST = 3e-3


@figure(
    "Controlled steps of average acceleration on the hardening spring. (a) Estimate of the error of a step over the "
    "true one, along a period; thin: its closed form on a linear oscillator. (b) Largest energy error of each period, "
    "with steps controlled in three ways and with about as many equal steps. (c) Distance from the start after the "
    "last period against the number of steps.",
    requires={
        "estimates.problems": [PROBLEM],
        "estimates.schemes": [SCHEME],
        "step_control.problems": [PROBLEM],
        "step_control.schemes": [SCHEME],
    },
)
def draw(estimates: xr.Dataset, step_control: xr.Dataset) -> Figure:
    """Three panels side by side: ratios of estimates, energy errors and final errors."""
    figure, ((first, second, third),) = panels(1, 3, PAGE, 7.2)
    _ratios(first, estimates.sel(problem=PROBLEM, scheme=SCHEME))
    control = step_control.sel(problem=PROBLEM, scheme=SCHEME)
    titles = dict(zip(control.controller.values, control.controller_title.values, strict=True)) | {
        "equal": "equal steps"
    }
    look = curve_styles_in_order(titles)
    _histories(second, control, titles, look)
    _errors(third, control, titles, look)
    for index, (ax, title) in enumerate(zip((first, second, third), ("estimates", "energy", "error"), strict=True)):
        letter(ax, index, title)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)
    return figure


def _ratios(ax: Axes, estimates: xr.Dataset) -> None:
    look = curve_styles_in_order(estimates.estimator.values)
    ax.axhline(1, color="0.7", linewidth=2.5, zorder=0)
    for name, curve in look.items():
        estimate = estimates.sel(estimator=name)
        ax.plot(
            estimates.phase, estimate.ratio, label=estimate.estimator_title.item(), markevery=12, markersize=3, **curve
        )
        ax.plot(estimates.phase, estimate.linear_ratio, color=curve["color"], linewidth=0.5)
    ax.set(yscale="log", ylim=(LEAST, None), xlabel="part of the period", ylabel="estimate over true error")


def _histories(ax: Axes, control: xr.Dataset, titles: dict, look: dict) -> None:
    for name, title in titles.items():
        error = 100 * control.max_energy_error_of_period.sel(with_equal=name)
        ax.plot(control.period_number, error, label=title, markevery=20, markersize=3, **look[name])
    ax.set(yscale="log", xlabel="period", ylabel="largest energy error (%)")


def _errors(ax: Axes, control: xr.Dataset, titles: dict, look: dict) -> None:
    for name, title in titles.items():
        if name == "equal":
            steps, error = control.steps_per_period, control.equal_return_error
        else:
            runs = control.sel(controller=name)
            steps, error = runs.steps / control.attrs["periods"], runs.return_error
        resolved = np.asarray(steps) >= control.steps_per_period.min().item()
        ax.plot(np.asarray(steps)[resolved], np.asarray(error)[resolved], label=title, markersize=3, **look[name])
    ax.set(xscale="log", yscale="log", xlabel="steps per period", ylabel="distance from the start")
    ax.xaxis.set_minor_formatter(NullFormatter())
