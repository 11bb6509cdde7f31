"""Energy error against time on rotating structures whose stiff modes the step does not resolve."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import TURNING
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure
from paper.requirements import one_of, samples_of_history

#: Smallest and largest error in percent; errors beyond are drawn at these values.
FLOOR, CEILING = 1e-13, 1e4


def sizes(history: xr.Dataset) -> xr.DataArray:
    """Absolute energy errors in percent after the start; NaN where they are not finite."""
    error = 100 * np.abs(history.energy_error.isel(t=slice(1, None)))
    return error.where(np.isfinite(error))


@figure(
    "Energy error against time of rotating structures, at steps that do not resolve their stiff modes. A cross marks "
    "the end of a run that fails. Errors below 10⁻¹³ % or above 10⁴ % are drawn at these values.",
    histories=["structure_history/stiff_bar", "structure_history/stiff_truss"],
    requires={
        "structure_history.stiff_bar.problem": one_of(TURNING),
        "structure_history.stiff_truss.problem": one_of(TURNING),
        "structure_history.stiff_bar": samples_of_history(1),
        "structure_history.stiff_truss": samples_of_history(1),
    },
)
def draw(histories: list[xr.Dataset]) -> Figure:
    """One panel per structure; a cross marks a run that ends early."""
    figure, axes = panels(1, len(histories), PAGE, 5.4, sharey=True)
    for index, (ax, history) in enumerate(zip(axes[0], histories, strict=True)):
        for place, (name, look) in enumerate(curve_styles(history.scheme).items()):
            run = history.sel(scheme=name)
            error = sizes(run).clip(FLOOR, CEILING)
            marks = (0.1 + 0.05 * place, 0.3) if error.notnull().any() else None
            ax.plot(error.t, error, label=run.scheme_title.item(), markevery=marks, **look)
            if run.status != 0:
                every = round((run.t[1] - run.t[0]).item() / run.step_size.item())
                end = max((run.failed_at_step.item() - 1) // every - 1, 0)
                ax.plot(error.t[end], error[end], "x", color=look["color"], markersize=7, markeredgewidth=1.5)
        ax.set(xlabel="elapsed time $t$ (s)", yscale="log")
        steps = history.steps_per_period.item()
        letter(ax, index, f"{history.problem_title}, {steps:g} steps")
    axes[0, 0].set_ylabel("energy error (%)")
    legend_below(figure, columns=5)
    return figure
