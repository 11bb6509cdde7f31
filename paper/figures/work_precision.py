"""Four measures of error against the computing time, or the force evaluations, of a run of a hundred periods."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import loss_of_amplitude, of_the_paper
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure
from paper.published import SCHEMES

#: Number of periods of the runs, and of shorter runs that show whether a change of amplitude is steady.
PERIODS, SHORTER = 100, 3
MEASURES = {
    "max_trajectory_error": "displacement",
    "period_elongation": "period",
    "amplitude_decay": "loss of amplitude",
    "max_energy_error": "energy",
}
#: Smallest error drawn; in smaller errors the round-off of a hundred periods dominates.
FLOOR = 1e-14
_REQUIRES = {
    "work_precision.schemes.schemes": SCHEMES,
    "work_precision.solvers.periods": [PERIODS],
    "accuracy.periods": [SHORTER, PERIODS],
}


def _draw(data: xr.Dataset, cost: str, label: str) -> Figure:
    """One row per problem, one column per measure of error, against the variable ``cost``."""
    data = of_the_paper(data)
    losses = loss_of_amplitude(data, SHORTER, PERIODS)
    data = data.sel(periods=PERIODS)
    rows = data.sizes["problem"]
    figure, axes = panels(rows, len(MEASURES), PAGE, max(2.8 * rows + 2, 8), sharex="row", sharey="col")
    for place, (row, problem) in enumerate(zip(axes, data.problem.values, strict=True)):
        one = data.sel(problem=problem)
        for column, (ax, (measure, title)) in enumerate(zip(row, MEASURES.items(), strict=True)):
            peer = one.sel(solver="heyoka")
            if cost == "median_seconds":
                reached = abs(peer[f"solver_{measure}"]).where(peer.solver_max_trajectory_error < 1)
                ax.plot(peer.median_solver_seconds, reached, "-*", color="0.6", label="heyoka")
            sizes = losses.sel(problem=problem) if measure == "amplitude_decay" else abs(one[measure])
            known = sizes.where((one.flagged.sel(measure=measure) == 0) & (sizes > FLOOR))
            for name, look in curve_styles(one.scheme).items():
                run = one.sel(scheme=name)
                ax.plot(run[cost], known.sel(scheme=name), label=run.scheme_title.item(), markevery=3, **look)
            ax.set(xscale="log", yscale="log")
            ax.set_ylim(top=3)
            letter(ax, place * len(MEASURES) + column, title)
        row[0].set_ylabel(one.problem_title.item().replace(", ", ",\n"))
    for ax in axes[-1]:
        ax.set_xlabel(label)
    legend_below(figure, columns=4)
    return figure


@figure(
    "Errors of the schemes of 1996 over 100 periods against the time of the run. Grey: heyoka at its tolerances.",
    data="work_precision",
    requires=_REQUIRES,
)
def over_time(data: xr.Dataset) -> Figure:
    """Errors against the computing time of a run; heyoka, a general solver, in grey."""
    return _draw(data, "median_seconds", "time (s)")


@figure(
    "Errors of the schemes of 1996 over 100 periods against the number of force evaluations, one per Newton iteration.",
    name="force_evaluations",
    data="work_precision",
    requires=_REQUIRES,
)
def over_forces(data: xr.Dataset) -> Figure:
    """Errors against the number of force evaluations, which sets the cost of expensive forces."""
    return _draw(data, "force_evaluations", "forces evaluated")
