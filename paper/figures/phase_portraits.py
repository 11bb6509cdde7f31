"""Phase portraits of the exact solution and of the schemes (Figures 1, 2 and 4 of the paper)."""

import math

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from paper.figures.style import PAGE, letter, panels
from paper.products import figure

_REACH = 4.0
#: Colours of elapsed time, from light to dark, so that the end of a run stands out; yellow is invisible on white.
_TIME = ListedColormap(plt.get_cmap("viridis_r")(np.linspace(0.15, 1, 256)))
_PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 1}


def _order(portrait: xr.Dataset) -> list[str]:
    """Schemes in the order of panels. In the double well the explicit schemes, not in the paper's figure, are last."""
    if portrait.problem != "double_well":
        return portrait.scheme.values.tolist()
    return portrait.scheme.sortby("explicit").values.tolist()


def _limits(reference: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Limits of an axis around the exact orbit and all points at most ``_REACH`` widths of the orbit away from it."""
    low, high = reference.min(), reference.max()
    reach = _REACH * (high - low)
    low, high = max(min(low, np.nanmin(values)), low - reach), min(max(high, np.nanmax(values)), high + reach)
    margin = 0.05 * (high - low)
    return low - margin, high + margin


@figure(
    "Figure 1 of Xie (1996): phase portraits of the hardening spring at T/20 over 100 periods, from light (start) "
    "to dark (end), and the exact orbit as a line.",
    name="hardening",
    portrait="phase_portrait/hardening",
    reference="reference/hardening",
)
@figure(
    "Figure 2 of Xie (1996): phase portraits of the softening spring at T/20 over 100 periods, from light (start) "
    "to dark (end), and the exact orbit as a line.",
    name="softening",
    portrait="phase_portrait/softening",
    reference="reference/softening",
)
@figure(
    "Figure 4 of Xie (1996): phase portraits of the double well at the step size 2.5 over a time of 2500, from "
    "light (start) to dark (end), and the exact orbit as a line.",
    name="double_well",
    portrait="phase_portrait/double_well",
    reference="reference/double_well",
)
def draw(portrait: xr.Dataset, reference: xr.Dataset) -> Figure:
    """Panel (a) exact, then one panel per scheme: points coloured by elapsed time, and the exact orbit over them."""
    rows = math.ceil((1 + portrait.sizes["scheme"]) / 4)
    figure, axes = panels(rows, 4, PAGE, 4.0 * rows + 0.4, sharex=True, sharey=True)
    used, unused = np.split(axes.ravel(), [1 + portrait.sizes["scheme"]])
    for ax in unused:
        ax.remove()
    periods = portrait.t / reference.period
    used[0].plot(reference.u, reference.v, color="#D55E00")
    letter(used[0], 0, "Exact")
    shown = portrait.where(portrait.status == 0)
    used[0].set_xlim(_limits(reference.u.values, shown.u.values))
    used[0].set_ylim(_limits(reference.v.values, shown.v.values))
    for index, scheme in enumerate(_order(portrait), start=1):
        ax, run = used[index], portrait.sel(scheme=scheme)
        time = {"c": periods, "cmap": _TIME, "vmin": 0, "vmax": periods[-1]}
        points = ax.scatter(run.u, run.v, s=3.5, linewidths=0, rasterized=True, **time)
        # drawn after the points, which would hide the exact orbit where a scheme is accurate
        ax.plot(reference.u, reference.v, color="#D55E00", linestyle="-", linewidth=0.5)
        letter(ax, index, run.scheme_title.item())
        if run.status != 0:
            ax.plot(run.u, run.v, color="0.4", linewidth=0.5, marker=".", markersize=3)
            what = run.status.flag_meanings.split()[int(run.status)].replace("_", " ")
            label = f"{what} at step {run.failed_at_step.item()}"
            ax.text(0.5, 0.04, label, transform=ax.transAxes, ha="center", fontsize=7, bbox=_PAPER)
    figure.supxlabel("displacement $u$", fontsize="medium")
    figure.supylabel("velocity $\\dot u$ (1/s)", fontsize="medium")
    figure.colorbar(points, ax=used, label="elapsed periods", pad=0.01, aspect=40)
    return figure
