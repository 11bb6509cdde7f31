"""Errors on problems with known displacements, and Lyapunov exponents of Ueda's oscillator, by number of steps."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.data import with_schemes
from paper.figures.style import PAGE, curve_styles, legend_in_gap, letter, panels, wrapped
from paper.products import figure

#: Schemes in the figure: explicit and implicit, with and without numerical damping.
SHOWN = [
    "average_acceleration",
    "central_difference",
    "houbolt",
    "bathe",
    "rk4",
    "gauss4",
]
COLUMNS = 5
#: Largest error drawn; at larger errors the motion is lost.
BEYOND = 3.0
#: Smallest error drawn; smaller ones, which may be zero, are drawn at this value.
SMALLEST = 1e-16


def _errors(ax: Axes, runs: xr.Dataset, styles: dict) -> None:
    """Draw the error of each scheme on a problem against the number of steps."""
    for name, style in styles.items():
        error = runs.end_error.sel(scheme=name)
        ax.plot(runs.steps, error.where(error < BEYOND).clip(min=SMALLEST), label=error.scheme_title.item(), **style)
    ax.set(xscale="log", yscale="log")
    ends = runs.steps.values[[0, -1]]
    ax.set_xticks(ends, [f"{n:,}" for n in ends])
    ax.minorticks_off()


@figure(
    "Error of the displacement against the number of steps, relative to published or exact displacements. A point is "
    "missing where a run failed or its error exceeds 3; an error of zero is drawn at 1e-16.",
)
def draw(published_numbers: xr.Dataset) -> Figure:
    """One panel per problem."""
    shown = with_schemes(published_numbers, SHOWN)
    number = shown.sizes["problem"]
    columns = min(number, COLUMNS)
    rows = -(-number // columns)
    figure, axes = panels(rows, columns, PAGE, 4.0 * rows + 1.2)
    styles = curve_styles(shown.scheme)
    for index, (ax, problem) in enumerate(zip(axes.flat, shown.problem.values, strict=False)):
        runs = shown.sel(problem=problem)
        _errors(ax, runs, styles)
        letter(ax, index, wrapped(runs.problem_title.item(), 16))
        if index + columns >= number:
            ax.set_xlabel("steps")
    figure.supylabel("error of the displacement", fontsize="medium")
    legend_in_gap(figure, axes, number, columns=4)
    return figure
