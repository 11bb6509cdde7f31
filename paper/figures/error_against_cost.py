"""Error against time and against evaluations of the force: six schemes at equal steps, and general solvers."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.data import SOLVERS
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels, whole_decades
from paper.products import figure
from study.sizes import unbroken

PROBLEM, PERIODS = "softening", 100
SCHEMES = ["central_difference", "average_acceleration", "generalized_alpha", "bathe", "rk4", "kahan_li8"]
#: General solvers of the figure, with their markers, and in each panel the distance in points of the name from the last
#: point, to the left of it if negative. The Taylor method of heyoka evaluates no force.
GENERAL: dict[str, tuple[str, list[tuple[float, float]]]] = {
    "scipy_dop853": ("o", [(-3, 4), (-4, -1)]),
    "cvode_adams": ("s", [(-4, -7), (-4, -7)]),
    "tsit5": ("v", [(5, -2.5), (5, -2.5)]),
    "heyoka": ("D", [(-4, -7)]),
}
NO_FORCE = "heyoka"
#: Largest and smallest error drawn: at larger errors the motion is lost, and smaller ones are round-off.
TOP, BOTTOM = 1.0, 1e-10
#: Label of each cost, with the names of its variables for schemes and for solvers.
_COSTS = {
    "computing time (s)": ("median_seconds", "median_solver_seconds"),
    "evaluations of the force": ("force_evaluations", "solver_force_evaluations"),
}


def _name(axes: Axes, solver: str, places: list[tuple[float, float]], offset: tuple[float, float]) -> None:
    """Write the name of a solver next to its last point, over the curves."""
    side = "right" if offset[0] < 0 else "left"
    for place in places[-1:]:
        name = axes.annotate(SOLVERS[solver], place, offset, textcoords="offset points", ha=side, color="0.3", zorder=3)
        name.set_bbox({"fc": "white", "ec": "none", "pad": 0.4, "alpha": 0.8})


@figure(
    "Error of the displacement over 100 periods of the softening spring against time and evaluations of the force. "
    "Lines: six schemes at equal steps. Grey: general solvers that could take their place, a point for each tolerance.",
    data="work_precision",
    requires={
        "work_precision.schemes.problems": [PROBLEM],
        "work_precision.solvers.periods": [PERIODS],
    },
)
def draw(data: xr.Dataset) -> Figure:
    """Largest error of the displacement, relative to the largest displacement, against two costs of a run.

    Schemes of the figure that were not run are left out.
    """
    data = data.sel(problem=PROBLEM, periods=PERIODS)
    looks = curve_styles(data.scheme)
    picture, (row,) = panels(1, 2, PAGE, 8.0, sharey=True)
    for place, (axes, (label, (scheme_cost, solver_cost))) in enumerate(zip(row, _COSTS.items(), strict=True)):
        for solver, (marker, offsets) in GENERAL.items():
            if solver == NO_FORCE and place:
                continue
            runs = data.sel(solver=solver).sortby("tolerance", ascending=False)
            known = runs.solver_last_period_error.where(runs.solver_last_period_error < TOP)
            look = {"color": "0.6", "marker": marker, "ls": ":", "lw": 0.8, "ms": 4, "label": SOLVERS[solver]}
            axes.plot(runs[solver_cost], known, **look)
            drawn = [at for at in zip(runs[solver_cost].values, known.values, strict=True) if at[1] > BOTTOM]
            _name(axes, solver, drawn, offsets[place])
        for scheme in (name for name in SCHEMES if name in data.scheme):
            runs = data.sel(scheme=scheme).sortby("steps_per_period", ascending=False)
            # a small error at a step that is coarser than one whose motion is lost is an accident
            kept = unbroken(runs.displacement_error.values < TOP)
            look = looks[scheme] | {"linestyle": "-", "linewidth": 1.4, "label": runs.scheme_title.item()}
            axes.plot(runs[scheme_cost], runs.displacement_error.where(kept), **look)
        for error in (0.1, 0.01, 0.001):
            axes.axhline(error, color="0.8", lw=0.6, zorder=0)
        axes.set(xscale="log", yscale="log", ylim=(BOTTOM, TOP), xlabel=label)
        # the panels have the same width whatever times were measured
        whole_decades(axes)
        letter(axes, place, "error against computing time" if place == 0 else "error against forces")
    row[0].set_ylabel("error of the displacement")
    # the names of the solvers are next to their points
    schemes = row[0].get_legend_handles_labels()[0][len(GENERAL) :]
    legend_below(picture, columns=6, handles=schemes)
    return picture
