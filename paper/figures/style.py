"""What the figures have in common: size, type, colours that survive greyscale, and how they are saved."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import xarray as xr
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.data import families, load

#: Width in inches of the page of the manuscript.
PAGE = 7.1
#: Titles of the general solvers that figures show, by their names in the datasets.
SOLVERS = {
    "cvode_adams": "CVODE Adams",
    "cvode_bdf": "CVODE BDF",
    "dopri8": "diffrax Dopri8",
    "tsit5": "diffrax Tsit5",
    "kvaerno5": "diffrax Kvaerno5",
    "scipy_dop853": "SciPy DOP853",
    "heyoka": "heyoka",
}

#: How a run can end, by the names in the maps of stability: what it is called, and a colour, the darker the worse, so
#: that the order is seen in greyscale too.
OUTCOMES = {
    "accurate": ("accurate", "#ffffff"),
    "bounded": ("bounded", "#d0e1f2"),
    "damped_to_rest": ("damped to rest", "#8fc1e0"),
    "in_the_wrong_well": ("in the wrong well", "#e69f00"),
    "chaotic": ("chaotic", "#cc79a7"),
    "growing": ("growing", "#c8500a"),
    "newton_not_converged": ("Newton did not converge", "#7f1d2d"),
    "not_finite": ("not finite", "#000000"),
}

# Okabe and Ito's palette without its yellow; line styles and markers tell the curves apart without any colour.
_LOOKS = (
    cycler(color=["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"])
    + cycler(linestyle=["-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1))])
    + cycler(marker=["o", "s", "v", "^", "D", "P", "X"])
)

plt.rcParams.update(
    {
        "font.size": 8,
        "axes.titlesize": 8,
        "axes.titlelocation": "left",
        "axes.labelsize": 8,
        "legend.fontsize": 7,
        "legend.frameon": False,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "axes.linewidth": 0.6,
        "lines.linewidth": 1.0,
        "lines.markersize": 3.5,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.constrained_layout.use": True,
        "savefig.dpi": 300,
        "image.cmap": "viridis",
        "pdf.fonttype": 42,
        "svg.hashsalt": "study",
    }
)


def looks(schemes: xr.DataArray) -> dict[str, dict]:
    """One look (colour, line style, marker) for each scheme, the same in every figure that shows the same schemes.

    Raises
    ------
    ValueError
        If there are more schemes than a panel can hold.
    """
    names = schemes.values.tolist()
    if len(names) > len(_LOOKS):
        raise ValueError(f"{len(names)} curves are more than a reader can tell apart; a panel holds {len(_LOOKS)}.")
    return dict(zip(names, _LOOKS, strict=False))


def a_panel_for_each_family(dataset: xr.Dataset, height: float, **shared) -> tuple[Figure, dict[Axes, xr.Dataset]]:
    """A figure with two columns of panels, and which family each of them is for."""
    parts = families(dataset)
    rows = -(-len(parts) // 2)
    figure, axes = plt.subplots(rows, 2, figsize=(PAGE, rows * height), squeeze=False, **shared)
    for empty in axes.ravel()[len(parts) :]:
        empty.remove()
    panels = dict(zip(axes.ravel(), parts.values(), strict=False))
    for index, (ax, name) in enumerate(zip(panels, parts, strict=True)):
        letter(ax, index, name)
    return figure, panels


def letter(axes: Axes, index: int, title: str) -> None:
    """Title of a panel: (a), (b), ... and what it shows."""
    axes.set_title(f"({chr(ord('a') + index)}) {title}")


def main(draw: Callable[..., Figure]) -> None:
    """Draw the datasets named on the command line and save the figure three times, the same bytes for the same data."""
    output, *paths = map(Path, sys.argv[1:])
    figure = draw(*map(load, paths))
    # one layout for all three, which takes as long as drawing
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    for suffix in (".pdf", ".png", ".svg"):
        figure.savefig(output.with_suffix(suffix), metadata={"Date": None} if suffix == ".svg" else None)
