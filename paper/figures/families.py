"""Error against time for every scheme, one panel per family."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import a_panel_for_each_family, legend_beside, looks
from paper.products import figure

PROBLEM, PERIODS = "hardening", 100
#: Largest error drawn; at larger ones the phase is lost.
TOP = 3


@figure(
    "Error against time of every scheme, by family.",
    data="work_precision",
    asks={
        "work_precision.schemes.schemes": ["rk4"],
        "work_precision.schemes.problems": [PROBLEM],
        "work_precision.solvers.periods": [PERIODS],
    },
)
def draw(data: xr.Dataset) -> Figure:
    """Error of the displacement against time; the classical Runge-Kutta method and heyoka in grey in every panel."""
    data = data.sel(problem=PROBLEM, periods=PERIODS)
    figure, panels = a_panel_for_each_family(data, height=2.1, sharex=True, sharey=True)
    common = data.sel(scheme="rk4")
    peer = data.sel(solver="heyoka")
    for ax, part in panels.items():
        known = common.max_trajectory_error.where(common.max_trajectory_error < TOP)
        ax.plot(common.time_per_run, known, color="0.75", linewidth=3)
        ax.plot(peer.solver_time_per_run, peer.solver_max_trajectory_error, color="0.6", marker=".", linestyle="none")
        for name, look in looks(part.scheme).items():
            run = part.sel(scheme=name)
            known = run.max_trajectory_error.where((run.max_trajectory_error < TOP) & (run.max_trajectory_error > 0))
            ax.plot(run.time_per_run, known, label=run.scheme_title.item(), markevery=2, **look)
        ax.set(xscale="log", yscale="log", ylim=(1e-12, TOP))
        legend_beside(ax)
    for ax in figure.axes[-2:]:
        ax.set_xlabel("time of 100 periods (s)")
    for ax in figure.axes[::2]:
        ax.set_ylabel("error of $u$")
    return figure
