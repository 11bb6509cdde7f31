"""Why Runge-Kutta's error at T/20 is smaller than at T/25: capture by a resonance of the step with the motion."""

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, main

PRINTED = {20: "1.0 %", 25: "8.3 %"}


def draw(drift: xr.Dataset) -> Figure:
    """Above the signed drift, below how many steps one of the last oscillations takes, over the step size."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(PAGE, 0.55 * PAGE), sharex=True)
    parts = drift.steps_per_period
    above.axhline(0, color="0.7", linewidth=0.6)
    above.plot(parts, drift.energy_drift, color="#0072B2", linewidth=0.6, marker=".", markersize=3)
    for part, text in PRINTED.items():
        value = drift.energy_drift.sel(steps_per_period=part, method="nearest")
        above.plot(part, value, "o", color="#D55E00", markersize=6, markerfacecolor="none")
        above.annotate(
            f"$T/{part}$, printed {text}",
            (part, value),
            xytext=(part + 1, -45),
            arrowprops={"arrowstyle": "-", "linewidth": 0.5},
        )
    above.set_ylabel("signed energy error\nafter 100 periods (%)")
    below.plot(parts, drift.steps_per_oscillation, color="#0072B2", linewidth=0.6, marker=".", markersize=3)
    below.plot(parts, parts, color="0.6", linestyle="--", linewidth=0.8, label="period kept")
    for whole in range(10, 32, 2):
        below.axhline(whole, color="0.85", linewidth=0.6, zorder=0)
    below.set(xlabel="steps per printed period", ylabel="steps per oscillation\nat the end")
    below.set_yticks(range(8, 42, 4))
    below.legend()
    return figure


if __name__ == "__main__":
    main(draw)
