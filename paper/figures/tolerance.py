"""True error of general solvers in their longest runs, against the tolerance."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import SOLVERS
from paper.figures.style import COLUMN, curve_styles_in_order, legend_below, letter, panels
from paper.products import figure

#: Titles of problems, where they differ from the names; the dataset has no titles.
_TITLES = {"softening_large": "softening,\nlarge amplitude"}


@figure(
    "True error of the displacement over the longest runs of general solvers against the prescribed "
    "tolerance. Above the grey line the error is larger than the tolerance.",
    agreement="reference_agreement",
)
def draw(agreement: xr.Dataset) -> Figure:
    """One panel per problem: the error of the displacement over the longest runs, against the tolerance."""
    rows = -(-agreement.sizes["problem"] // 2)
    figure, axes = panels(rows, 2, COLUMN, 3.9 * rows + 2.2, sharex=True, sharey=True)
    periods = agreement.periods.max()
    for index, (ax, problem) in enumerate(zip(axes.flat, agreement.problem.values, strict=False)):
        ax.plot(agreement.tolerance, agreement.tolerance, color="0.8", linewidth=2.5, label="error = tolerance")
        for route, look in curve_styles_in_order(agreement.route.values).items():
            error = agreement.displacement_error.sel(problem=problem, route=route, periods=periods)
            ax.plot(agreement.tolerance, error, label=SOLVERS[route], **look)
        ax.set(xscale="log", yscale="log")
        ax.set_xticks([1e-4, 1e-8, 1e-12])
        ax.minorticks_off()
        letter(ax, index, _TITLES.get(problem, problem.replace("_", " ")))
    for ax in axes.flat[agreement.sizes["problem"] :]:
        ax.remove()
    axes[0, 0].invert_xaxis()
    axes[0, 0].set(ylim=(None, 30))
    for ax in axes[-1]:
        ax.set_xlabel("relative tolerance")
    for ax in axes[:, 0]:
        ax.set_ylabel(f"error, {periods:d} periods")
    legend_below(figure, columns=2)
    return figure
