"""Phase portraits of the exact solution and of the schemes (Figures 1, 2 and 4 of the paper)."""

import math

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter
from paper.products import figure

_REACH = 4.0
_PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 1}


def _order(portrait: xr.Dataset) -> list[str]:
    """The order of the paper's panels; the explicit schemes, without a panel for the double well, come last there."""
    if portrait.problem != "double_well":
        return portrait.scheme.values.tolist()
    return portrait.scheme.sortby("explicit").values.tolist()


def _limits(reference: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Limits around the exact orbit and the points of the schemes, at most ``_REACH`` widths of the orbit away."""
    low, high = reference.min(), reference.max()
    reach = _REACH * (high - low)
    low, high = max(min(low, np.nanmin(values)), low - reach), min(max(high, np.nanmax(values)), high + reach)
    margin = 0.05 * (high - low)
    return low - margin, high + margin


@figure(
    "Phase portraits of the hardening spring at T/20.",
    name="hardening",
    portrait="phase_portrait/hardening",
    reference="reference/hardening",
)
@figure(
    "Phase portraits of the softening spring at T/20.",
    name="softening",
    portrait="phase_portrait/softening",
    reference="reference/softening",
)
@figure(
    "Phase portraits of the double well at Δt = 2.5.",
    name="double_well",
    portrait="phase_portrait/double_well",
    reference="reference/double_well",
)
def draw(portrait: xr.Dataset, reference: xr.Dataset) -> Figure:
    """Panel (a) exact, then one panel per scheme, coloured by elapsed time over the exact orbit in grey."""
    rows = math.ceil((1 + portrait.sizes["scheme"]) / 4)
    figure, axes = plt.subplots(rows, 4, figsize=(PAGE, 0.26 * rows * PAGE), sharex=True, sharey=True)
    panels, unused = np.split(axes.ravel(), [1 + portrait.sizes["scheme"]])
    for ax in unused:
        ax.remove()
    periods = portrait.t / reference.period
    panels[0].plot(reference.u, reference.v, color="black")
    letter(panels[0], 0, "Exact")
    shown = portrait.where(portrait.status == 0)
    panels[0].set_xlim(_limits(reference.u.values, shown.u.values))
    panels[0].set_ylim(_limits(reference.v.values, shown.v.values))
    for index, scheme in enumerate(_order(portrait), start=1):
        ax, run = panels[index], portrait.sel(scheme=scheme)
        ax.plot(reference.u, reference.v, color="0.75", linewidth=0.8, zorder=0)
        points = ax.scatter(run.u, run.v, c=periods, s=1.5, linewidths=0, rasterized=True, vmin=0, vmax=periods[-1])
        letter(ax, index, run.scheme_title.item())
        if run.status != 0:
            ax.plot(run.u, run.v, color="0.4", linewidth=0.5, marker=".", markersize=3)
            what = run.status.flag_meanings.split()[int(run.status)].replace("_", " ")
            label = f"{what} at step {run.failed_at_step.item()}"
            ax.text(0.5, 0.04, label, transform=ax.transAxes, ha="center", fontsize=7, bbox=_PAPER)
    figure.supxlabel("displacement $u$", fontsize=8)
    figure.supylabel("velocity $\\dot u$ (1/s)", fontsize=8)
    figure.colorbar(points, ax=panels, label="elapsed periods", pad=0.01, aspect=40)
    return figure
