"""Error against evaluations of the force, with controlled and with equal steps, and with a general solver."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import SOLVERS
from paper.figures.style import PAGE, curve_styles_in_order, legend_below, letter, panels, wrapped
from paper.measures.step_control import ALLOWED
from paper.products import figure

#: Schemes and general solver in the figure, and the maximum number of panels.
SHOWN, SOLVER, MOST = ["average_acceleration", "rk4", "dormand_prince6"], "cvode_adams", 8
COLUMNS = 4


@figure(
    "Error of the displacement against evaluations of the force. Solid: equal steps. Dashed: steps controlled by PI. "
    "Grey: CVODE's Adams methods. A finer step may have a larger error.",
    requires={"control_cost.schemes": SHOWN[:1]},
)
def draw(control_cost: xr.Dataset, solver_cost: xr.Dataset) -> Figure:
    """One panel per problem."""
    shown = [name for name in SHOWN if name in control_cost.scheme]
    problems = control_cost.problem.values[:MOST]
    rows = -(-len(problems) // COLUMNS)
    columns = -(-len(problems) // rows)
    figure, axes = panels(rows, columns, PAGE, 5 * rows + 1.2, sharey=True)
    for index, (ax, problem) in enumerate(zip(axes.flat, problems, strict=False)):
        costs = control_cost.sel(problem=problem)
        ax.axhline(ALLOWED, color="0.85", linewidth=2, zorder=0)
        for name, look in curve_styles_in_order(shown).items():
            runs = costs.sel(scheme=name)
            title, look = runs.scheme_title.item(), look | {"markersize": 3, "linewidth": 1}
            ax.plot(runs.equal_force_evaluations, runs.equal_sampled_error, label=title, **look | {"linestyle": "-"})
            ax.plot(
                runs.force_evaluations, runs.sampled_error, **look | {"linestyle": "--", "markerfacecolor": "white"}
            )
        if problem in solver_cost.problem and SOLVER in solver_cost.solver:
            solver = solver_cost.sel(problem=problem, solver=SOLVER)
            ax.plot(
                solver.force_evaluations,
                solver.sampled_error,
                label=SOLVERS[SOLVER],
                color="0.5",
                linewidth=2,
                linestyle=":",
            )
        ax.set(xscale="log", yscale="log", ylim=(1e-7, 3))
        ax.set_xlabel("evaluations of the force")
        letter(ax, index, wrapped(costs.problem_title.item(), 16))
    for ax in axes[:, 0]:
        ax.set_ylabel("error of the displacement\nover its size")
    for unused in axes.ravel()[len(problems) :]:
        unused.remove()
    fullest = max(axes.ravel()[: len(problems)], key=lambda ax: len(ax.get_legend_handles_labels()[0]))
    legend_below(figure, 5, fullest)
    return figure
