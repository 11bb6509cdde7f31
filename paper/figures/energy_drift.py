"""Why Runge-Kutta's error at T/20 is smaller than at T/25: capture by a resonance of the step with the motion."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.asks import OF_THE_DRIFT
from paper.figures.style import PAGE
from paper.products import figure
from paper.published import printed_energy_errors

#: The two step sizes that the paper compares, and the places of their labels.
_MARKED = {20: (21.5, -70), 25: (26.5, -40)}


@figure(
    "Energy drift of the Runge-Kutta method over step size, with its resonances.",
    drift="energy_drift",
    asks=OF_THE_DRIFT,
)
def draw(drift: xr.Dataset) -> Figure:
    """Signed drift (above) and steps per oscillation at the end (below) over the step size."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(PAGE, 0.55 * PAGE), sharex=True)
    parts = drift.steps_per_period
    above.axhline(0, color="0.7", linewidth=0.6)
    above.plot(parts, drift.energy_drift, color="#0072B2", linewidth=0.6, marker=".", markersize=3)
    printed = printed_energy_errors().sel(problem=drift.problem, scheme=drift.scheme)
    for part, place in _MARKED.items():
        value = drift.energy_drift.sel(steps_per_period=part, method="nearest")
        above.plot(part, value, "o", color="#D55E00", markersize=6, markerfacecolor="none")
        label = f"$T/{part}$, printed {printed.sel(steps_per_period=part):.1f} %"
        above.annotate(label, (part, value), xytext=place, arrowprops={"arrowstyle": "-", "linewidth": 0.5})
    above.set_ylabel(f"signed energy error\nafter {drift.periods:d} periods (%)")
    below.plot(parts, drift.steps_per_oscillation, color="#0072B2", linewidth=0.6, marker=".", markersize=3)
    below.plot(parts, parts, color="0.6", linestyle="--", linewidth=0.8, label="period kept")
    for whole in range(10, 32, 2):
        below.axhline(whole, color="0.85", linewidth=0.6, zorder=0)
    below.set(xlabel="steps per printed period", ylabel="steps per oscillation\nat the end")
    below.set_yticks(range(8, 42, 4))
    below.legend()
    return figure
