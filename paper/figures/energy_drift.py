"""Why Runge-Kutta's error at T/20 is smaller than at T/25: capture by a resonance of the step with the motion."""

import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, letter, panels
from paper.products import figure
from paper.published import printed_energy_errors
from paper.requirements import RESONANCE

#: Numbers of steps per period that the paper compares, each with the place of its label.
_MARKED = {20: (22.0, -68), 25: (27.0, -38)}
_CURVE = {"color": "#0072B2", "linewidth": 0.6, "marker": ".", "markersize": 2.5}


@figure(
    "Energy error of the Runge-Kutta method on the softening spring over the step size. Circles: two neighbouring "
    "entries of Table 2 of Xie (1996), of which the coarser step has the smaller error. A resonance holds the orbit "
    "where the steps per oscillation stay at a whole number over a range of step sizes.",
    drift="energy_drift",
    requires=RESONANCE,
)
def draw(drift: xr.Dataset) -> Figure:
    """Signed energy error (above) and steps per oscillation at the end (below), against the steps per period."""
    figure, ((above,), (below,)) = panels(2, 1, COLUMN, 7.5, sharex=True)
    parts = drift.steps_per_period
    above.axhline(0, color="0.7", linewidth=0.6)
    above.plot(parts, 100 * drift.energy_drift, **_CURVE)
    printed = printed_energy_errors().sel(problem=drift.problem, scheme=drift.scheme)
    for part, place in _MARKED.items():
        value = 100 * drift.energy_drift.sel(steps_per_period=part, method="nearest")
        above.plot(part, value, "o", color="#D55E00", markersize=6, markerfacecolor="none", zorder=3)
        label = f"$T/{part}$: printed {printed.sel(steps_per_period=part):.1f} %"
        above.annotate(label, (part, value), xytext=place, arrowprops={"arrowstyle": "-", "linewidth": 0.5})
    above.set_ylabel(f"signed energy error\nafter {drift.periods:d} periods (%)")
    letter(above, 0, "energy")
    for whole in range(10, 32, 2):
        below.axhline(whole, color="0.85", linewidth=0.6, zorder=0)
    below.plot(parts, parts, color="0.4", linestyle="--", linewidth=0.8, label="exact period")
    below.plot(parts, drift.steps_per_oscillation, **_CURVE, label="Runge-Kutta")
    below.set(xlabel="steps in the period printed in 1996", ylabel="steps per oscillation\nat the end")
    below.set_yticks(range(8, 42, 8))
    below.legend()
    letter(below, 1, "period")
    return figure
