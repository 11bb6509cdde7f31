"""Four measures of error against the step size."""

import xarray as xr
from matplotlib.figure import Figure

from paper.data import loss_of_amplitude, schemes_of_1996
from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels, wrapped
from paper.products import figure
from paper.published import SCHEMES

MEASURES = {
    "displacement_error": "displacement $u$",
    "phase_error": "delay (periods)",
    "amplitude_decay": "loss of amplitude",
    "max_energy_error": "energy",
}
PROBLEM = "hardening"
#: Schemes of a row of panels, by its title.
ROWS = {
    "schemes without damping, Runge-Kutta": ["average_acceleration", "central_difference", "rk4"],
    "schemes with numerical damping": ["newmark_dissipative", "wilson_theta", "houbolt", "hht_alpha_1996"],
}
#: Number of periods of the runs, and of shorter runs that show whether a change of amplitude is steady.
PERIODS, SHORTER = 100, 3


@figure(
    "Errors of the seven schemes of Xie (1996) over 100 periods of the hardening spring against the step size. The "
    "slope of a curve is the order of its error. Errors that the reference does not resolve, and "
    "changes of amplitude that do not grow with the length of the run, are omitted.",
    requires={
        "accuracy.schemes": SCHEMES,
        "accuracy.problems": [PROBLEM],
        "accuracy.periods": [SHORTER, PERIODS],
    },
)
def draw(accuracy: xr.Dataset) -> Figure:
    """One column per measure; errors that the reference does not resolve are omitted."""
    accuracy = schemes_of_1996(accuracy).sel(problem=PROBLEM)
    losses = loss_of_amplitude(accuracy, SHORTER, PERIODS)
    accuracy = accuracy.sel(periods=PERIODS)
    figure, axes = panels(len(ROWS), len(MEASURES), PAGE, 9, sharex=True, sharey="col")
    for place, (row, (title, schemes)) in enumerate(zip(axes, ROWS.items(), strict=True)):
        for column, (ax, (measure, label)) in enumerate(zip(row, MEASURES.items(), strict=True)):
            sizes = losses if measure == "amplitude_decay" else abs(accuracy[measure])
            known = sizes.where(accuracy.flagged.sel(measure=measure) == 0)
            for name, look in curve_styles(accuracy.scheme.sel(scheme=schemes)).items():
                curve = known.sel(scheme=name)
                ax.plot(curve.steps_per_period, curve, label=curve.scheme_title.item(), markevery=2, **look)
            ax.set(xscale="log", yscale="log")
            ax.set_xticks([10, 100, 1000])
            letter(ax, place * len(MEASURES) + column, label)
        row[0].set_ylabel(wrapped(title, 26))
    for ax in axes[-1]:
        ax.set_xlabel("steps per period")
    handles = [curve for ax in axes[:, 0] for curve in ax.lines]
    legend_below(figure, columns=4, handles=handles)
    return figure
