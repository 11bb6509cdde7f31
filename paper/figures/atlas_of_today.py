"""Maps of how runs end over step size and amplitude, for the later schemes: one small panel per problem."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import contained
from paper.figures.outcome_map import legend, outcome_map
from paper.figures.style import PAGE
from paper.products import figure
from paper.published import SCHEMES

#: Schemes side by side.
COLUMNS = 3


def _others(schemes: list[str]) -> str | None:
    """A sentence if there are no maps but those of the paper's schemes."""
    if set(schemes) <= set(SCHEMES):
        return "atlas.schemes has none but those of the paper; a figure shows the others, give one at least."
    return None


@figure(
    "Outcome of each run over step size and amplitude, with later schemes.",
    atlas="stability/atlas",
    spectral="spectral",
    asks={
        "": contained("atlas.schemes", "spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "atlas.schemes": _others,
    },
)
def draw(atlas: xr.Dataset, spectral: xr.Dataset) -> Figure:
    """One block per scheme: hardening spring, softening spring, double well from left to right."""
    atlas = atlas.drop_sel(scheme=SCHEMES, errors="ignore")
    schemes, problems = atlas.scheme.values, atlas.problem.values
    rows = -(-len(schemes) // COLUMNS)
    figure = plt.figure(figsize=(PAGE, 0.97 * rows + 0.5))
    blocks = np.asarray(figure.subfigures(rows, COLUMNS)).ravel()
    for index, (block, scheme) in enumerate(zip(blocks, schemes, strict=False)):
        of_scheme = atlas.sel(scheme=scheme)
        limit = spectral.stability_limit.sel(scheme=scheme, damping_ratio=0.0).item()
        block.suptitle(of_scheme.scheme_title.item(), fontsize=7)
        panels = block.subplots(1, len(problems), sharey=True)
        for ax, problem in zip(panels, problems, strict=True):
            outcome_map(ax, of_scheme.sel(problem=problem), limit)
            # ticks have labels in the lowest panel of each column and in the first of each row
            labels = ["0.01", "0.1", "1"] if index + COLUMNS >= len(schemes) else [""] * 3
            ax.set_xticks([0.01, 0.1, 1], labels, fontsize=5)
            ax.minorticks_off()
            if index < COLUMNS:
                title = of_scheme.problem_title.sel(problem=problem).item().removesuffix(" spring")
                ax.set_title(title, fontsize=5, loc="center")
        panels[0].set_yticks([0.1, 1, 10], ["0.1", "1", "10"] if index % COLUMNS == 0 else [""] * 3, fontsize=5)
    legend(figure, atlas.outcome.values, cases=False)
    return figure
