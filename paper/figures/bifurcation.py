"""Order and chaos of the average acceleration method in the double well, and how soon neighbouring runs separate."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import COLUMN, letter, panels
from paper.products import figure


@figure(
    "Average acceleration in the double well over the step size; dashed: the step of Figure 4 of Xie (1996). (a) "
    "Displacements at the end of each run, (b) Lyapunov exponent, positive in chaos, (c) steps after which two "
    "neighbouring runs have separated.",
    bifurcation="stability/bifurcation",
)
def draw(bifurcation: xr.Dataset) -> Figure:
    """Last displacements, Lyapunov exponent per step, and steps until a perturbation is of order one, by step size."""
    figure, axes = panels(3, 1, COLUMN, 12, sharex=True, height_ratios=[1.5, 1, 1.2])
    axes = axes[:, 0]
    dt = bifurcation.step_size.values
    axes[0].plot(
        np.repeat(dt, bifurcation.sizes["iterate"]),
        bifurcation.u.values.ravel(),
        ".",
        color="black",
        markersize=max(1.2 * (36_100 / bifurcation.u.size) ** 0.5, 0.6),  # more points, smaller markers
        markeredgewidth=0,
        rasterized=True,
    )
    axes[0].set(ylabel="displacement $u$", ylim=(-2.5, 2.5))
    a_step = bifurcation.lyapunov_exponent * dt
    axes[1].plot(dt, a_step, ".", markersize=2, color="#0072B2")
    axes[1].axhline(0, color="black", linewidth=0.6)
    axes[1].set(ylabel="exponent × step")
    # A perturbation grows by the factor exp(λΔt) per step. Step sizes at which it does not reach order one within the
    # run are omitted.
    small, large = bifurcation.perturbation.item(), bifurcation.order_one.item()
    growth = np.log(large / small)
    chaotic = (a_step.values > growth / bifurcation.steps.item()) & (bifurcation.status == 0).values
    axes[2].semilogy(
        dt[chaotic], growth / a_step.values[chaotic], ".", markersize=3, color="#E69F00", label="from the exponent"
    )
    measured = np.where(bifurcation.steps_until_apart > 0, bifurcation.steps_until_apart, np.nan)
    axes[2].semilogy(dt, measured, ".", markersize=2, color="black", label="of two runs")
    axes[2].set(ylabel="steps", xlabel="step size Δt (s)", xlim=(dt[0], dt[-1]))
    figure.legend(handles=axes[2].get_legend_handles_labels()[0], loc="outside lower center", ncols=2, markerscale=1.5)
    for index, title in enumerate(
        ("last displacements of each run", "Lyapunov exponent", "steps until neighbouring runs separate")
    ):
        axes[index].axvline(2.5, color="#D55E00", linewidth=0.8, linestyle="--")
        letter(axes[index], index, title)
    return figure
