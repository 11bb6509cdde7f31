"""Four measures of error against the step size."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import loss_of_amplitude, schemes_of_1996
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure
from paper.published import SCHEMES

MEASURES = {
    "displacement_error": "displacement $u$",
    "phase_error": "delay (periods)",
    "amplitude_decay": "loss of amplitude",
    "max_energy_error": "energy",
}
PROBLEMS = ("hardening", "softening")
#: Number of periods of the runs, and of shorter runs that show whether a change of amplitude is steady.
PERIODS, SHORTER = 100, 3


@figure(
    "Errors of the seven schemes of Xie (1996) over 100 periods against the step size, one row per spring. The "
    "slope of a curve is the order of its error. Errors that the reference does not resolve, and "
    "changes of amplitude that do not grow with the length of the run, are omitted.",
    requires={
        "accuracy.schemes": SCHEMES,
        "accuracy.problems": list(PROBLEMS),
        "accuracy.periods": [SHORTER, PERIODS],
    },
)
def draw(accuracy: xr.Dataset) -> Figure:
    """One row per problem, one column per measure; errors that the reference does not resolve are omitted."""
    accuracy = schemes_of_1996(accuracy)
    losses = loss_of_amplitude(accuracy, SHORTER, PERIODS)
    accuracy = accuracy.sel(periods=PERIODS)
    figure, axes = panels(len(PROBLEMS), len(MEASURES), PAGE, 10, sharex=True, sharey="col")
    for place, (row, problem) in enumerate(zip(axes, PROBLEMS, strict=True)):
        for column, (ax, (measure, label)) in enumerate(zip(row, MEASURES.items(), strict=True)):
            sizes = losses if measure == "amplitude_decay" else abs(accuracy[measure])
            known = sizes.where(accuracy.flagged.sel(measure=measure) == 0).sel(problem=problem)
            for name, look in curve_styles(accuracy.scheme).items():
                curve = known.sel(scheme=name)
                ax.plot(curve.steps_per_period, curve, label=curve.scheme_title.item(), markevery=2, **look)
            ax.set(xscale="log", yscale="log")
            ax.set_xticks([10, 100, 1000])
            letter(ax, place * len(MEASURES) + column, label)
        row[0].set_ylabel(accuracy.problem_title.sel(problem=problem).item())
    for ax in axes[-1]:
        ax.set_xlabel("steps per period")
    legend_below(figure, columns=4)
    return figure
