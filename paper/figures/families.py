"""Error against the computing time of a run for every scheme, one panel per family."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import curve_styles, figure_of_families, legend_in
from paper.products import figure

PROBLEM, PERIODS = "hardening", 100
#: Largest error drawn; at larger errors the phase is lost.
TOP = 3


@figure(
    "Error of the displacement after 100 periods of the hardening spring against the time of the run, by family. "
    "Grey curve: the Runge-Kutta method of 1996; grey points: heyoka at its tolerances.",
    data="work_precision",
    requires={
        "work_precision.schemes.schemes": ["rk4"],
        "work_precision.schemes.problems": [PROBLEM],
        "work_precision.solvers.periods": [PERIODS],
    },
)
def draw(data: xr.Dataset) -> Figure:
    """Error of the displacement against computing time; grey: the Runge-Kutta method and heyoka, in every panel."""
    data = data.sel(problem=PROBLEM, periods=PERIODS)
    figure, columns = figure_of_families(data, 1, 4.2)
    common = data.sel(scheme="rk4")
    peer = data.sel(solver="heyoka")
    for part, (ax, below) in columns:
        known = common.displacement_error.where(common.displacement_error < TOP)
        ax.plot(common.median_seconds, known, color="0.8", linewidth=3)
        ax.plot(
            peer.median_solver_seconds,
            peer.solver_last_period_error,
            color="0.5",
            marker="*",
            linestyle="none",
        )
        for name, look in curve_styles(part.scheme).items():
            run = part.sel(scheme=name)
            known = run.displacement_error.where((run.displacement_error < TOP) & (run.displacement_error > 0))
            ax.plot(run.median_seconds, known, label=run.scheme_title.item(), markevery=2, **look)
        ax.set(xscale="log", yscale="log", ylim=(1e-12, TOP), xlabel="time of 100\nperiods (s)")
        legend_in(below, ax)
    figure.axes[0].set_ylabel("error of the displacement")
    return figure
