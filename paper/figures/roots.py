"""How many roots the effective equation of a step has in the double well, and which of them Newton finds."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from paper.figures.style import PAGE, letter, looks
from paper.products import figure

#: Colours of the tolerances of Newton's iteration.
COLOURS = ("#56B4E9", "#0072B2", "#000000")


def _one_for_each_colour(tolerances: list) -> str | None:
    if len(tolerances) == len(COLOURS):
        return None
    return f"stability.roots.tolerances must be {len(COLOURS)}, one for each colour of a figure, not {len(tolerances)}."


@figure(
    "Roots of the effective equation of a step, and the root that Newton finds.",
    roots="stability/roots",
    asks={"stability.roots.schemes": ["houbolt"], "stability.roots.tolerances": _one_for_each_colour},
)
def draw(roots: xr.Dataset) -> Figure:
    """Regions with three roots, the root that Newton finds, and how long runs of two tolerances agree."""
    figure, axes = plt.subplots(1, 3, figsize=(PAGE, 0.36 * PAGE))
    styles = looks(roots.scheme)
    for scheme, style in styles.items():
        several = (roots.number_of_roots.sel(scheme=scheme) > 1).T
        axes[0].contour(
            roots.dt, roots.predictor, several, levels=[0.5], colors=[style["color"]], linestyles=[style["linestyle"]]
        )
    axes[0].axvline(roots.paper_dt.item(), color="0.5", linewidth=0.8)
    axes[0].set(xlabel="step size in s", ylabel="predictor of the displacement", ylim=(-3, 3))
    handles = [
        Line2D([], [], color=s["color"], linestyle=s["linestyle"], label=roots.scheme_title.sel(scheme=n).item())
        for n, s in styles.items()
    ]
    axes[0].legend(handles=handles, loc="upper left", fontsize=6)
    houbolt = roots.root.sel(scheme="houbolt").T
    picture = axes[1].pcolormesh(roots.guess, roots.predictor, houbolt, cmap="cividis", rasterized=True)
    figure.colorbar(picture, ax=axes[1], label="displacement found")
    axes[1].set(xlabel="where Newton starts", ylabel="predictor of the displacement")
    for start, line in zip(roots.start.values, ("-", ":"), strict=True):
        for tolerance, colour in zip(roots.newton_tolerance.values, COLOURS, strict=True):
            axes[2].semilogy(
                roots.dt,
                roots.steps_together.sel(start=start, newton_tolerance=tolerance).clip(min=1),
                line,
                color=colour,
                linewidth=0.8,
                label=f"{tolerance:.0e}" if line == "-" else None,
            )
    axes[2].plot([], [], ":", color="0.4", label="from none")
    axes[2].set(xlabel="step size in s", ylabel="steps until they differ")
    axes[2].legend(title="tolerance", loc="lower left", fontsize=6)
    for index, (ax, title) in enumerate(
        zip(axes, ["three roots inside", "Houbolt's root at Δt = 2.5", "average acceleration"], strict=True)
    ):
        letter(ax, index, title)
    return figure
