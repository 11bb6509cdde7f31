"""Coefficients of the energy error of motions in several potentials, and predicted against measured period errors."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure


@figure(
    "Errors of motions in several potentials from the modified energy. (a) Energy error over (ωΔt)², one point per "
    "motion; lines: the largest value for a tangent that is nowhere negative. (b) Measured against predicted error of "
    "the period at the step bound of the energy.",
    bound="stability/step_bound",
)
def draw(bound: xr.Dataset) -> Figure:
    """Panel (a): the coefficient by potential; panel (b): the error of the period."""
    figure, (axes,) = panels(1, 2, PAGE, 7.5)
    by_potential, measured = axes
    names = list(dict.fromkeys(bound.potential_title.values))
    place = np.array([names.index(name) for name in bound.potential_title.values])
    predicted = bound.coefficient * bound.omega_step**2
    for name, look in curve_styles(bound.scheme).items():
        motions = bound.sel(scheme=name)
        style = look | {"linestyle": "", "markersize": 3, "label": motions.scheme_title.item()}
        by_potential.plot(motions.coefficient.sel(quantity="energy"), place, **style)
        by_potential.axvline(
            motions.convex_coefficient.item(), color=look["color"], linestyle=look["linestyle"], lw=0.8
        )
        period = {"scheme": name, "quantity": "period"}
        measured.plot(100 * predicted.sel(period), 100 * bound.measured_error.sel(period), **style)
    by_potential.set(xlabel="energy error over the square of ωΔt", xlim=(0, None))
    by_potential.set_yticks(range(len(names)), names)
    by_potential.invert_yaxis()
    period_errors = 100 * predicted.sel(quantity="period")
    ends = [period_errors.min(), period_errors.max()]
    measured.plot(ends, ends, color="0.6", linewidth=0.8, label="measured as predicted")
    measured.set(xscale="log", yscale="log", xlabel="predicted period error (%)", ylabel="measured period error (%)")
    letter(by_potential, 0, "energy")
    letter(measured, 1, "period")
    legend_below(figure, columns=3)
    return figure
