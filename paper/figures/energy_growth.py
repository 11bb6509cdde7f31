"""Energy error on turning structures whose stiff modes the step does not resolve."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import one_of, samples_of_history
from paper.data import TURNING
from paper.figures.style import PAGE, letter, looks
from paper.products import figure

#: Smallest error in percent; smaller ones are drawn at this value.
FLOOR = 1e-13


@figure(
    "Energy error of structures that turn, where the step does not resolve stiff modes.",
    histories=["structure_history/stiff_bar", "structure_history/stiff_truss"],
    asks={
        "structure_history.stiff_bar.problem": one_of("structure_history.stiff_bar.problem", TURNING),
        "structure_history.stiff_truss.problem": one_of("structure_history.stiff_truss.problem", TURNING),
        "structure_history.stiff_bar": samples_of_history("structure_history.stiff_bar", 1),
        "structure_history.stiff_truss": samples_of_history("structure_history.stiff_truss", 1),
    },
)
def draw(histories: list[xr.Dataset]) -> Figure:
    """One panel per structure; a cross marks a run that ends early."""
    figure, axes = plt.subplots(1, len(histories), figsize=(PAGE, 0.4 * PAGE), sharey=True)
    for index, (ax, history) in enumerate(zip(axes, histories, strict=True)):
        for name, look in looks(history.scheme).items():
            one = history.sel(scheme=name)
            error = np.maximum(np.abs(one.energy_error), FLOOR).where(np.isfinite(one.energy_error))
            (line,) = ax.plot(one.t[1:], error[1:], label=one.scheme_title.item(), **{**look, "marker": ""})
            if one.status != 0:
                every = round((one.t[1] - one.t[0]).item() / one.dt.item())
                end = max((one.failed_at_step.item() - 1) // every, 1)
                ax.plot(one.t[end], error[end], "x", color=line.get_color(), markersize=6)
        ax.set(xlabel="time", yscale="log")
        letter(ax, index, history.problem_title)
    axes[0].set_ylabel("energy error (%)")
    handles, titles = axes[0].get_legend_handles_labels()
    figure.legend(handles, titles, loc="outside lower center", ncols=min(len(titles), 5))
    return figure
