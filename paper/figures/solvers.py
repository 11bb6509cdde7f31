"""Error against cost of general solvers at a series of tolerances, and of the Runge-Kutta method at fixed steps."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import SOLVERS
from paper.figures.style import PAGE, curve_styles_in_order, legend_below, letter, panels, wrapped
from paper.products import figure

#: Largest error drawn; at larger errors the solution is lost.
TOP = 3
#: Solvers in the figure, and the scheme at fixed steps with which they are compared.
SHOWN, SCHEME = ("cvode_adams", "dopri8", "kvaerno5", "scipy_dop853", "heyoka"), "rk4"
#: Label of each cost, with the names of its variables for schemes and for solvers.
_COSTS = {
    "time (s)": ("median_seconds", "median_solver_seconds"),
    "evaluations of the force": ("force_evaluations", "solver_force_evaluations"),
}


@figure(
    "Error of the displacement over 100 periods against time (above) and evaluations of the force (below): "
    "general solvers, a point for each tolerance, and the Runge-Kutta method at fixed steps (grey).",
    data="work_precision",
    requires={"work_precision.schemes.schemes": [SCHEME], "work_precision.solvers.periods": [100]},
)
def draw(data: xr.Dataset) -> Figure:
    """Error of the displacement over a hundred periods against computing time (above) and force evaluations (below)."""
    data = data.sel(periods=100)
    size = data.sizes["problem"]
    figure, axes = panels(2, size, PAGE, 9, sharex="row", sharey=True)
    for index, (row, (label, (scheme_cost, solver_cost))) in enumerate(zip(axes, _COSTS.items(), strict=True)):
        for column, (ax, problem) in enumerate(zip(row, data.problem.values, strict=True)):
            runs = data.sel(problem=problem)
            run = runs.sel(scheme=SCHEME)
            error = run.displacement_error.where(run.displacement_error < TOP)
            ax.plot(run[scheme_cost], error, color="0.7", linestyle="-", linewidth=2.5, label=run.scheme_title.item())
            for solver, look in curve_styles_in_order(SHOWN).items():
                run = runs.sel(solver=solver)
                error = run.solver_last_period_error.where(run.solver_last_period_error < TOP)
                ax.plot(run[solver_cost], error, label=SOLVERS[solver], **look)
            ax.set(xscale="log", yscale="log", xlabel=label, ylim=(1e-11, TOP))
            letter(ax, index * size + column, wrapped(runs.problem_title.item(), 18))
        row[0].set_ylabel("error of displacement")
    legend_below(figure, columns=5)
    return figure
