"""Maps of how runs end, over step size and amplitude, for the later schemes: one panel per scheme and problem."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.outcome_map import legend, outcome_map, step_ticks
from paper.figures.style import PAGE, empty, wrapped
from paper.products import figure
from paper.published import SCHEMES
from paper.requirements import contained

#: Number of schemes side by side.
COLUMNS = 3
#: Largest height of the figure in cm.
TALLEST = 19.0


def _others(schemes: list[str]) -> str:
    return "has only schemes of the paper; this figure shows the others" if set(schemes) <= set(SCHEMES) else ""


@figure(
    "How each run of the later schemes ends, over step size (T/100 to T) and initial displacement; the three maps "
    "of a scheme are those of the hardening spring, the softening spring and the double well.",
    atlas="stability/atlas",
    requires={
        "": contained("atlas.schemes", within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "atlas.schemes": _others,
    },
)
def draw(atlas: xr.Dataset, spectral: xr.Dataset) -> Figure:
    """One block of panels per scheme, with one panel per problem from left to right."""
    atlas = atlas.drop_sel(scheme=SCHEMES, errors="ignore")
    number, problems = atlas.sizes["scheme"], atlas.problem.values
    blocks = min(number, COLUMNS)
    rows = -(-number // blocks)
    figure = empty(PAGE, min(1.8 * rows + 3.4, TALLEST))
    # a narrow column separates the blocks
    widths = ([1.0] * len(problems) + [0.12]) * blocks
    grid = figure.add_gridspec(rows, len(widths) - 1, width_ratios=widths[:-1])
    for index, scheme in enumerate(atlas.scheme.values):
        row, block = divmod(index, blocks)
        limit = spectral.stability_limit.sel(scheme=scheme, damping_ratio=0.0).item()
        for place, problem in enumerate(problems):
            ax = figure.add_subplot(grid[row, block * (len(problems) + 1) + place])
            outcomes = atlas.sel(scheme=scheme, problem=problem)
            outcome_map(ax, outcomes, limit)
            step_ticks(ax, {0.01: "0.01", 0.1: "", 1: "1"})
            ax.set_yticks([0.1, 1, 10], ["0.1", "1", "10"])
            lowest = row == rows - 1
            ax.tick_params(labelbottom=lowest, labelleft=block == place == 0)
            if lowest:
                ax.set_xlabel(f"Δt/T,\n{wrapped(outcomes.problem_title.item(), 10)}")
            if place == len(problems) // 2:
                ax.set_title(outcomes.scheme_title.item(), loc="center", pad=2)
    figure.supylabel("initial displacement over its value of 1996", fontsize="medium")
    legend(figure, atlas.outcome.values, cases=False)
    return figure
