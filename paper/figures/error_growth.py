"""Errors of displacement, phase, energy and amplitude against the length of the run."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, curve_styles, legend_below, letter, panels
from paper.products import figure

#: Schemes drawn: two that keep the energy, and four that dissipate.
SHOWN = ("average_acceleration", "central_difference", "newmark_dissipative", "houbolt", "bathe", "rk4")
#: Measures by the title of their panel, and the exponents of the grey lines.
MEASURES = {
    "displacement": ("displacement_error", (1, 2)),
    "phase, periods": ("phase_error", (1, 2)),
    "energy": ("max_energy_error", (1,)),
    "loss of amplitude": ("amplitude_decay", (1,)),
}


@figure(
    "Errors on the hardening spring against the number of periods. Grey: growth with the number of periods, dashed "
    "with its square. A loss of amplitude that does not grow is left out.",
    growth="error_growth",
    requires={"accuracy.problems": ["hardening"]},
)
def draw(growth: xr.Dataset) -> Figure:
    """One panel per measure, at the finest step."""
    figure, axes = panels(1, 4, PAGE, 6.0, sharex=True)
    errors = growth.sel(problem="hardening").isel(steps_per_period=-1)
    errors = errors.sel(scheme=[name for name in SHOWN if name in errors.scheme.values])
    known = (errors.flagged == 0).rename(measure="of")
    periods = errors.periods.values
    for index, (ax, (title, (measure, powers))) in enumerate(zip(axes.flat, MEASURES.items(), strict=True)):
        error = abs(errors[measure]).where(known.sel(of=measure))
        if measure == "amplitude_decay":
            error = (1 - (1 - error) ** error.periods).where(np.isfinite(errors.order_of_loss))
        for name, look in curve_styles(errors.scheme).items():
            ax.plot(periods, error.sel(scheme=name), label=errors.scheme_title.sel(scheme=name).item(), **look)
        for power in powers:
            low = float(error.isel(periods=slice(0, 2)).min())
            line = low / 3 * (periods / periods[0]) ** power
            ax.plot(periods, np.where(line < 3, line, np.nan), color="0.6", lw=0.8, ls="-" if power == 1 else "--")
        ax.set(xscale="log", yscale="log", xlabel="periods")
        letter(ax, index, title)
    axes[0, 0].set_ylabel("error")
    legend_below(figure, columns=3)
    return figure
