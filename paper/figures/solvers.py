"""General solvers at a ladder of tolerances beside two schemes at fixed steps."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, SOLVERS, letter, looks
from paper.products import figure

#: Largest error drawn; at larger ones the solution is lost.
TOP = 3
#: Schemes at fixed steps, by their greys.
SCHEMES = {"central_difference": "0.7", "rk4": "0.4"}


@figure(
    "Error against cost of general solvers, beside two schemes at fixed steps.",
    data="work_precision",
    asks={"work_precision.schemes.schemes": list(SCHEMES), "work_precision.solvers.periods": [100]},
)
def draw(data: xr.Dataset) -> Figure:
    """Error of the displacement over a hundred periods against time (above) and evaluations (below)."""
    data = data.sel(periods=100)
    size = data.sizes["problem"]
    figure, axes = plt.subplots(2, size, figsize=(PAGE, 0.72 * PAGE), sharex="row", sharey=True, squeeze=False)
    costs = {"time_per_run": "time (s)", "force_evaluations": "evaluations"}
    solver_costs = {"time_per_run": "solver_time_per_run", "force_evaluations": "solver_evaluations"}
    for index, (row, cost) in enumerate(zip(axes, costs, strict=True)):
        for column, (ax, problem) in enumerate(zip(row, data.problem.values, strict=True)):
            one = data.sel(problem=problem)
            for scheme, grey in SCHEMES.items():
                run = one.sel(scheme=scheme)
                error = run.max_trajectory_error.where(run.max_trajectory_error < TOP)
                ax.plot(run[cost].where(error < TOP), error, color=grey, linewidth=2.5, label=run.scheme_title.item())
            for solver, look in looks(xr.DataArray(list(SOLVERS))).items():
                run = one.sel(solver=solver)
                error = run.solver_max_trajectory_error
                ax.plot(
                    run[solver_costs[cost]].where(error < TOP), error.where(error < TOP), label=SOLVERS[solver], **look
                )
            ax.set(xscale="log", yscale="log", xlabel=costs[cost], ylim=(1e-11, TOP))
            letter(ax, index * size + column, problem.replace("_", " "))
        row[0].set_ylabel("error over 100 periods")
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=5)
    return figure
