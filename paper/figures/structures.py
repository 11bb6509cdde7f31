"""Error of the displacement of structures against the step size."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, looks
from paper.products import figure

#: Schemes of every kind.
SHOWN = [
    "average_acceleration",
    "central_difference",
    "houbolt",
    "bathe",
    "implicit_midpoint",
    "energy_momentum",
    "gauss4",
]
COLUMNS = 3
#: Largest error, relative to the displacement, that the limits of a panel include.
BEYOND = 100


@figure("Error of the displacement of structures against step size.", structures="structures")
def draw(structures: xr.Dataset) -> Figure:
    """One panel per structure; a failed run leaves a gap."""
    shown = structures.sel(scheme=[name for name in SHOWN if name in structures.scheme.values])
    rows = -(-shown.sizes["problem"] // COLUMNS)
    figure, axes = plt.subplots(rows, COLUMNS, figsize=(PAGE, 0.27 * PAGE * rows), sharex=True, squeeze=False)
    for empty in axes.ravel()[shown.sizes["problem"] :]:
        empty.remove()
    for index, (ax, problem) in enumerate(zip(axes.ravel(), shown.problem.values, strict=False)):
        one = shown.sel(problem=problem)
        for name, look in looks(shown.scheme).items():
            ax.plot(
                one.steps_per_period,
                one.displacement_error.sel(scheme=name),
                label=one.scheme_title.sel(scheme=name).item(),
                **look,
            )
        ax.axhline(one.displacement_uncertainty.item(), color="0.7", linewidth=0.6)
        ax.set(xscale="log", yscale="log")
        ax.set_xticks(one.steps_per_period.values, [f"{n:g}" for n in one.steps_per_period.values])
        ax.minorticks_off()
        seen = one.displacement_error.where(one.displacement_error < BEYOND)
        if seen.notnull().any():
            ax.set_ylim(seen.min() / 3, 3 * seen.max())
        letter(ax, index, one.problem_title.item())
        if index + COLUMNS >= shown.sizes["problem"]:
            ax.set_xlabel("steps in the time scale")
            ax.tick_params(labelbottom=True)
    for ax in axes[:, 0]:
        ax.set_ylabel("largest error of the\ndisplacement, relative")
    handles, titles = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, titles, loc="outside lower center", ncols=4)
    return figure
