"""Every measure of error against the time, or the forces, of a run of a hundred periods."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.data import of_the_paper
from paper.figures.style import PAGE, letter, looks
from paper.products import figure
from paper.published import SCHEMES

PERIODS = 100
MEASURES = {
    "max_trajectory_error": "displacement",
    "period_elongation": "period",
    "amplitude_decay": "amplitude",
    "max_energy_error": "energy (%)",
}
#: Smallest error drawn; below it round-off of a hundred periods dominates.
FLOOR = 1e-14
_ASKS = {"work_precision.schemes.schemes": SCHEMES, "work_precision.solvers.periods": [PERIODS]}


def _draw(data: xr.Dataset, cost: str, label: str) -> Figure:
    """One row per problem, one column per measure of error, over a cost."""
    data = of_the_paper(data).sel(periods=PERIODS)
    shape = data.sizes["problem"], len(MEASURES)
    figure, axes = plt.subplots(*shape, figsize=(PAGE, 1.15 * PAGE), sharex="row", sharey="col", squeeze=False)
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


@figure("Errors of displacement, period, amplitude and energy against time.", data="work_precision", asks=_ASKS)
def over_time(data: xr.Dataset) -> Figure:
    """Errors over the time of a run; heyoka, the fastest of the general solvers, in grey."""
    return _draw(data, "time_per_run", "time of 100 periods (s)")


@figure(
    "Errors of displacement, period, amplitude and energy against force evaluations.",
    name="force_evaluations",
    data="work_precision",
    asks=_ASKS,
)
def over_forces(data: xr.Dataset) -> Figure:
    """Errors over the forces evaluated, where a force is expensive: each Newton iteration takes one."""
    return _draw(data, "force_evaluations", "forces in 100 periods")
