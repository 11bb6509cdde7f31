"""Lyapunov exponents of the numerical maps of structures over the step size."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, looks
from paper.products import figure

#: Exponents up to which a panel has a linear scale.
LINEAR = 2.0


@figure(
    "Lyapunov exponents of the schemes on structures.",
    structures="stability/structures",
    asks={"stability.structures.excitations": [1]},
)
def draw(structures: xr.Dataset) -> Figure:
    """One panel per structure."""
    structures = structures.sel(excitation=1)
    problems = structures.problem.values
    columns = min(len(problems), 3)
    rows = -(-len(problems) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(PAGE, 2.1 * rows + 0.4), squeeze=False)
    styles = looks(structures.scheme)
    for empty in axes.ravel()[len(problems) :]:
        empty.remove()
    for index, (ax, problem) in enumerate(zip(axes.ravel(), problems, strict=False)):
        one = structures.sel(problem=problem)
        for scheme, style in styles.items():
            ax.plot(
                one.steps_per_period,
                one.lyapunov_exponent.sel(scheme=scheme),
                label=one.scheme_title.sel(scheme=scheme).item() if index == 0 else None,
                **style,
            )
        ax.axhline(0, color="black", linewidth=0.6)
        ax.set(xscale="log", xlabel="steps in its time scale")
        if np.nanmax(np.abs(one.lyapunov_exponent)) > LINEAR:
            ax.set_yscale("symlog", linthresh=1)
        ax.set_xticks(one.steps_per_period.values[::2], [str(v) for v in one.steps_per_period.values[::2]])
        ax.minorticks_off()
        letter(ax, index, one.problem_title.item())
    for row in axes:
        row[0].set_ylabel("exponent in a time scale")
    figure.legend(loc="outside lower center", ncols=6)
    return figure
