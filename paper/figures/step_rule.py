"""The largest safe step by the highest frequency of the motion, against steps per period."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import largest_safe, of_kinds
from paper.figures.style import PAGE, legend_below, letter, looks, panels
from paper.products import figure

#: Allowed error of energy and period in percent.
ERROR = 1.0
SHOWN = ["average_acceleration", "central_difference", "rk4", "bathe", "energy_momentum"]


@figure(
    f"Largest step that keeps energy and period within {ERROR:g} %, as all finer ones of the maps do: its product with "
    "the highest frequency of the tangent along the motion, against the steps per period. Each point is an amplitude.",
    atlas="stability/atlas",
)
def draw(atlas: xr.Dataset) -> Figure:
    """One panel per spring, one curve per scheme along the amplitudes."""
    chosen = of_kinds(atlas, SHOWN)
    safe = largest_safe(chosen, ERROR)
    safe = safe.where(safe > 0)
    figure, axes = panels(1, chosen.sizes["problem"], PAGE, 7, sharex=True, sharey=True)
    for index, (ax, problem) in enumerate(zip(axes[0], chosen.problem.values, strict=True)):
        of_problem = chosen.sel(problem=problem)
        for name, look in looks(chosen.scheme).items():
            steps = safe.sel(scheme=name, problem=problem)
            title = chosen.scheme_title.sel(scheme=name).item()
            stiff = steps * of_problem.period * of_problem.highest_frequency
            ax.plot(1 / steps, stiff, label=title, markersize=3, **look | {"linestyle": ""})
        ax.set(xscale="log", yscale="log", xlabel="steps per period, $T/\\Delta t$")
        ax.set_xticks([10, 20, 50, 100], ["10", "20", "50", "100"])
        ax.set_yticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
        ax.minorticks_off()
        letter(ax, index, of_problem.problem_title.item())
    axes[0, 0].set_ylabel("$\\omega_\\mathrm{max} \\Delta t$")
    legend_below(figure, columns=5)
    return figure
