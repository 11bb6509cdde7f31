"""Order and chaos of the average acceleration method in the double well, and how soon neighbouring runs separate."""

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter
from paper.products import figure


@figure(
    "Bifurcation diagram and Lyapunov exponent of average acceleration in the double well.",
    bifurcation="stability/bifurcation",
)
def draw(bifurcation: xr.Dataset) -> Figure:
    """Iterates, Lyapunov exponent, and steps until a perturbation is of order one, over the step size."""
    figure, axes = plt.subplots(3, 1, figsize=(PAGE, 0.8 * PAGE), sharex=True, height_ratios=[1.6, 1, 1])
    dt = bifurcation.dt.values
    axes[0].plot(
        np.repeat(dt, bifurcation.sizes["iterate"]),
        bifurcation.u.values.ravel(),
        ".",
        color="black",
        markersize=0.6,
        markeredgewidth=0,
        alpha=0.6,
        rasterized=True,
    )
    axes[0].set(ylabel="displacement", ylim=(-2.5, 2.5))
    a_step = bifurcation.lyapunov_exponent * dt
    axes[1].plot(dt, a_step, ".", markersize=2, color="#0072B2")
    axes[1].axhline(0, color="black", linewidth=0.6)
    axes[1].set(ylabel="exponent, a step")
    # by the exponent λ alone a perturbation grows by e^λΔt per step; left out where the run ends before
    small, large = bifurcation.perturbation.item(), bifurcation.order_one.item()
    growth = np.log(large / small)
    chaotic = (a_step.values > growth / bifurcation.steps.item()) & (bifurcation.status == 0).values
    axes[2].semilogy(
        dt[chaotic], growth / a_step.values[chaotic], ".", markersize=3, color="#E69F00", label="from the exponent"
    )
    measured = np.where(bifurcation.steps_until_apart > 0, bifurcation.steps_until_apart, np.nan)
    axes[2].semilogy(dt, measured, ".", markersize=2, color="black", label="of two runs")
    failed = np.where(bifurcation.failed_at_step >= 0, bifurcation.failed_at_step, np.nan)
    axes[2].semilogy(dt, failed, "x", markersize=2, markeredgewidth=0.5, color="#8c1c4a", label="Newton fails")
    axes[2].set(ylabel="steps", xlabel="step size in s", xlim=(dt[0], dt[-1]))
    axes[2].legend(loc="lower left", ncols=3, markerscale=2)
    for ax in axes:
        ax.axvline(2.5, color="#D55E00", linewidth=0.8, linestyle="--")
    for index, (ax, title) in enumerate(
        zip(
            axes,
            ["last iterates", "Lyapunov exponent", f"steps until a perturbation of {small:g} is {large:g}"],
            strict=True,
        )
    ):
        letter(ax, index, title)
    return figure
