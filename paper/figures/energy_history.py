"""Energy error of the schemes against time, which the paper describes but does not show."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, curve_styles, legend_below, letter, panels
from paper.products import figure
from paper.requirements import steps_of_portrait

#: Number of steps in each stretch of a run; the largest error of the stretch is drawn.
STRETCH = 20


def _envelope(error: xr.DataArray, steps: int) -> xr.DataArray:
    """Largest absolute error of each group of ``steps`` samples; all samples oscillate and would blacken the panel."""
    return abs(error).isel(t=slice(1, None)).coarsen(t=steps, boundary="trim").max()


@figure(
    "Largest energy error in each stretch of 20 steps against time, in the runs of Figures 1 and 2 of Xie (1996).",
    portraits=["phase_portrait/hardening", "phase_portrait/softening"],
    requires={
        "phase_portrait.hardening": steps_of_portrait(STRETCH),
        "phase_portrait.softening": steps_of_portrait(STRETCH),
    },
)
def draw(portraits: list[xr.Dataset]) -> Figure:
    """One panel per problem: the largest |E − E₀|/E₀ in each stretch of 20 steps, on a logarithmic scale."""
    figure, axes = panels(len(portraits), 1, COLUMN, 10.5)
    for index, (ax, portrait) in enumerate(zip(axes.flat, portraits, strict=True)):
        for place, (name, look) in enumerate(curve_styles(portrait.scheme).items()):
            run = portrait.sel(scheme=name)
            envelope = _envelope(100 * run.energy_error, STRETCH)
            # matplotlib cannot place markers along a curve of fewer than two points on a logarithmic axis
            marked = (0.02 + 0.02 * place, 0.15) if (np.isfinite(envelope) & (envelope > 0)).sum() > 1 else None
            ax.plot(envelope.t, envelope, label=run.scheme_title.item(), markevery=marked, **look)
        ax.set(ylabel="energy error (%)", yscale="log")
        letter(ax, index, portrait.problem_title)
    axes[-1, 0].set_xlabel("elapsed time $t$ (s)")
    legend_below(figure, columns=3)
    return figure
