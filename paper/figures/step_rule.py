"""Largest safe step times the highest frequency of the motion, against the steps per period."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import largest_omega_step
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure

#: Allowed relative error of energy and period.
ERROR = 0.01


@figure(
    f"Largest step at and below which all tried steps keep energy and period within {100 * ERROR:g} %. Its product "
    "with the highest frequency of the tangent along the motion is drawn against the steps per period, one point per "
    "amplitude.",
    rule="stability/step_rule",
)
def draw(rule: xr.Dataset) -> Figure:
    """One panel per spring, one marker per scheme and amplitude."""
    safe = largest_omega_step(rule, ERROR)
    safe = safe.where(safe > 0)
    figure, axes = panels(1, rule.sizes["problem"], PAGE, 7, sharex=True, sharey=True)
    for index, (ax, problem) in enumerate(zip(axes[0], rule.problem.values, strict=True)):
        motions = rule.sel(problem=problem)
        for name, look in curve_styles(rule.scheme).items():
            stiff = safe.sel(scheme=name, problem=problem)
            title = rule.scheme_title.sel(scheme=name).item()
            steps = motions.period * motions.highest_frequency / stiff
            ax.plot(steps, stiff, label=title, markersize=3, **look | {"linestyle": ""})
        ax.set(xscale="log", yscale="log", xlabel="steps per period, $T/\\Delta t$")
        ax.set_xticks([10, 20, 50, 100, 200, 500], ["10", "20", "50", "100", "200", "500"])
        ax.set_yticks([0.1, 0.2, 0.5, 1, 2], ["0.1", "0.2", "0.5", "1", "2"])
        ax.minorticks_off()
        letter(ax, index, motions.problem_title.item())
    axes[0, 0].set_ylabel("highest frequency × step")
    legend_below(figure, columns=5)
    return figure
