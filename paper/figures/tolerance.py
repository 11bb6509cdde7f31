"""True error after a hundred periods against the tolerance of general solvers."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, SOLVERS, letter, looks
from paper.products import figure


@figure("True error of general solvers against the tolerance asked for.", agreement="reference_agreement")
def draw(agreement: xr.Dataset) -> Figure:
    """One panel per problem: the largest error of the displacement over a hundred periods, over the tolerance."""
    figure, (axes,) = plt.subplots(
        1, agreement.sizes["problem"], figsize=(PAGE, 0.4 * PAGE), sharex=True, sharey=True, squeeze=False
    )
    for index, (ax, problem) in enumerate(zip(axes, agreement.problem.values, strict=True)):
        ax.plot(agreement.tolerance, agreement.tolerance, color="0.7", linewidth=0.8, label="as asked for")
        for route, look in looks(agreement.route).items():
            error = agreement.u_error.sel(problem=problem, route=route, periods=agreement.periods.max())
            ax.plot(agreement.tolerance, error, label=SOLVERS[route], **look)
        ax.set(xscale="log", yscale="log", xlabel="relative tolerance")
        ax.set_xticks([1e-4, 1e-8, 1e-12])
        ax.minorticks_off()
        letter(ax, index, problem.replace("_", " "))
    axes[0].invert_xaxis()
    axes[0].set(ylabel="error over 100 periods", ylim=(None, 30))
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure
