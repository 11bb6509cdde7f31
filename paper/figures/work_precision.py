"""What accuracy costs: every measure of error against the time, or the forces, of a run of a hundred periods."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import of_the_paper
from paper.figures.style import PAGE, letter, looks, main

PERIODS = 100
MEASURES = {
    "max_trajectory_error": "displacement",
    "period_elongation": "period",
    "amplitude_decay": "amplitude",
    "max_energy_error": "energy (%)",
}
#: Below this the round-off of a hundred periods hides what a scheme does.
FLOOR = 1e-14


def draw(data: xr.Dataset, cost: str = "time_per_run", label: str = "time of 100 periods (s)") -> Figure:
    """A row a problem, a column a measure of error; heyoka, the fastest of the general solvers, in grey."""
    data = of_the_paper(data).sel(periods=PERIODS)
    shape = data.sizes["problem"], len(MEASURES)
    figure, axes = plt.subplots(*shape, figsize=(PAGE, 1.15 * PAGE), sharex="row", sharey="col")
    for row, problem in zip(axes, data.problem.values, strict=True):
        one = data.sel(problem=problem)
        for ax, (measure, title) in zip(row, MEASURES.items(), strict=True):
            peer = one.sel(solver="heyoka")
            peer = peer.where(peer.solver_max_trajectory_error < 1)
            if cost == "time_per_run":
                ax.plot(
                    peer.solver_time_per_run, abs(peer[f"solver_{measure}"]), color="0.6", marker=".", label="heyoka"
                )
            for name, look in looks(one.scheme).items():
                run = one.sel(scheme=name)
                size = abs(run[measure])
                known = size.where((run.flagged.sel(measure=measure) == 0) & (size > FLOOR))
                ax.plot(run[cost], known, label=run.scheme_title.item(), markevery=3, **look)
            ax.set(xscale="log", yscale="log")
            ax.set_ylim(top=300 if measure == "max_energy_error" else 3)
            letter(ax, int(np.flatnonzero(axes.ravel() == ax)[0]), title)
        row[0].set_ylabel(one.problem_title.item().replace(", ", ",\n"))
    for ax in axes[-1]:
        ax.set_xlabel(label)
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure


if __name__ == "__main__":
    main(draw)
