"""Maps of how runs end, over step size and amplitude, for the schemes of 1996."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import schemes_of_1996
from paper.figures.outcome_map import PAPER_CASES, legend, outcome_map, step_ticks
from paper.figures.style import PAGE, panels, wrapped
from paper.products import figure
from paper.published import SCHEMES
from paper.requirements import contained


@figure(
    "How each run of the schemes of 1996 ends, over step size and initial displacement. Dashed: the linear limit "
    "of stability at the stiffest place of each motion; markers: the runs of Figures 3 and 4 of Xie (1996).",
    atlas="stability/atlas",
    requires={
        "": contained("atlas.schemes", within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "atlas.schemes": SCHEMES,
    },
)
def draw(atlas: xr.Dataset, spectral: xr.Dataset) -> Figure:
    """One row per scheme, one column per problem."""
    atlas = schemes_of_1996(atlas)
    schemes, problems = atlas.scheme.values, atlas.problem.values
    figure, axes = panels(len(schemes), len(problems), PAGE, 19, sharex=True, sharey=True)
    for row, scheme in zip(axes, schemes, strict=True):
        limit = spectral.stability_limit.sel(scheme=scheme, damping_ratio=0.0).item()
        for ax, problem in zip(row, problems, strict=True):
            outcomes = atlas.sel(scheme=scheme, problem=problem)
            outcome_map(ax, outcomes, limit)
            for case in PAPER_CASES:
                if case.problem == problem and case.scheme in (scheme, None):
                    ax.plot(
                        *case.place(outcomes), marker=case.marker, color="black", markersize=6, markeredgecolor="white"
                    )
    for ax, title in zip(axes[0], atlas.problem_title.values, strict=True):
        ax.set_title(title)
    for row, title in zip(axes, atlas.scheme_title.values, strict=True):
        row[0].set_ylabel(wrapped(title, 12))
    for ax in axes[-1]:
        ax.set_xlabel("step size over period, Δt/T")
        step_ticks(ax, {0.01: "1/100", 0.05: "1/20", 0.2: "1/5", 1: "1"})
    axes[0, 0].set_yticks([0.1, 1, 10], ["0.1", "1", "10"])
    figure.supylabel("initial displacement over its value of 1996", fontsize="medium")
    legend(figure, atlas.outcome.values)
    return figure
