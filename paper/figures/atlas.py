"""Maps of how runs end over step size and amplitude, for the schemes of 1996."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import contained
from paper.data import of_the_paper
from paper.figures.outcome_map import PAPER_CASES, legend, outcome_map
from paper.figures.style import PAGE
from paper.products import figure
from paper.published import SCHEMES


@figure(
    "Outcome of each run over step size and amplitude, with the schemes of 1996.",
    atlas="stability/atlas",
    spectral="spectral",
    asks={
        "": contained("atlas.schemes", "spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "atlas.schemes": SCHEMES,
    },
)
def draw(atlas: xr.Dataset, spectral: xr.Dataset) -> Figure:
    """One row per scheme, one column per problem."""
    atlas = of_the_paper(atlas)
    schemes, problems = atlas.scheme.values, atlas.problem.values
    figure, axes = plt.subplots(
        len(schemes), len(problems), figsize=(PAGE, 1.28 * len(schemes)), sharex=True, sharey=True
    )
    for row, scheme in zip(axes, schemes, strict=True):
        limit = spectral.stability_limit.sel(scheme=scheme, damping_ratio=0.0).item()
        for ax, problem in zip(row, problems, strict=True):
            one = atlas.sel(scheme=scheme, problem=problem)
            outcome_map(ax, one, limit)
            for case in PAPER_CASES:
                if case.problem == problem and case.scheme in (scheme, None):
                    ax.plot(*case.place(one), marker=case.marker, color="black", markersize=6, markeredgecolor="white")
    for ax, title in zip(axes[0], atlas.problem_title.values, strict=True):
        ax.set_title(title)
    for row, title in zip(axes, atlas.scheme_title.values, strict=True):
        row[0].set_ylabel(title)
    for ax in axes[-1]:
        ax.set_xlabel("step size over period")
        ax.set_xticks([0.01, 0.05, 0.2, 1], ["1/100", "1/20", "1/5", "1"])
        ax.minorticks_off()
    figure.supylabel("initial displacement over that of 1996", fontsize=8)
    legend(figure, atlas.outcome.values)
    return figure
