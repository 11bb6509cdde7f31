"""Maps of how runs end, with the linear limit of stability and the runs of the paper."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from paper.figures.style import OUTCOME_STYLES, legend_below


class RunOf1996(NamedTuple):
    """A run of the paper with its marker on a map. ``scheme`` is None if the maps of all schemes have the marker."""

    title: str
    problem: str
    u0: float
    dt: float
    scheme: str | None
    marker: str

    def place(self, outcomes: xr.Dataset) -> tuple[float, float]:
        """Coordinates of the run on a map: step size over period at the nearest amplitude, and relative amplitude."""
        nearest = outcomes.isel(amplitude=int(np.argmin(np.abs(np.log(outcomes.u0.values / self.u0)))))
        return self.dt / nearest.period.item(), self.u0 / nearest.u0.item() * nearest.amplitude.item()


#: Runs of Figure 3 (softening spring at its large amplitude) and of Figure 4 (double well) of the paper.
PAPER_CASES = (
    RunOf1996("Figure 3 of 1996", "softening", 10.0, 0.225, None, "v"),
    RunOf1996("Figure 4 of 1996", "double_well", 0.5, 2.5, None, "o"),
)


#: Style of the line of the linear limit of stability, visible on black and on white.
LIMIT: dict[str, Any] = {
    "color": "black",
    "linewidth": 1.1,
    "linestyle": "--",
    "path_effects": [withStroke(linewidth=2.6, foreground="white")],
}


#: Options for drawing the outcomes as an image. With a mesh, each panel would be rasterized at the size of the whole
#: page, which would exhaust the memory.
IMAGE: dict[str, Any] = {
    "cmap": ListedColormap([colour for _, colour in OUTCOME_STYLES.values()]),
    "vmin": -0.5,
    "vmax": len(OUTCOME_STYLES) - 0.5,
    "origin": "lower",
    "aspect": "auto",
    "interpolation": "nearest",
}


def _edges(axis: xr.DataArray) -> tuple[float, float]:
    """Outer edges of the first and the last cell of an axis whose values are in geometric progression."""
    first, last = axis.values[[0, -1]]
    half = (last / first) ** (0.5 / (len(axis) - 1))
    return first / half, last * half


def outcome_map(ax: Axes, outcomes: xr.Dataset, limit: float) -> None:
    """Draw outcomes over step size and amplitude, and the step size at the linear limit of stability of ωΔt.

    Here ω is the highest frequency along the motion.

    Parameters
    ----------
    outcomes
        Map of one scheme on one problem.
    limit
        Stability limit of ωΔt on the linear oscillator. If it is infinite, no line is drawn.
    """
    ax.set_label(f"{outcomes.scheme_title.item()}, {outcomes.problem_title.item()}")
    ax.set(xscale="log", yscale="log", xlim=_edges(outcomes.step_size_over_period), ylim=_edges(outcomes.amplitude))
    # in panel coordinates, because cells have different sizes in data coordinates
    ax.imshow(outcomes.outcome, extent=(0, 1, 0, 1), transform=ax.transAxes, **IMAGE)
    if np.isfinite(limit):
        ax.plot(limit / (outcomes.highest_frequency * outcomes.period), outcomes.amplitude, **LIMIT)


def step_ticks(ax: Axes, labels: Mapping[float, str]) -> None:
    """Set the ticks of the step size. Outer labels stay within the panel, so that labels of two panels do not touch."""
    ax.set_xticks(list(labels), list(labels.values()))
    ax.minorticks_off()
    first, *_, last = ax.get_xticklabels()
    first.set_horizontalalignment("left")
    last.set_horizontalalignment("right")


def patches(outcomes: np.ndarray, best: str = OUTCOME_STYLES["accurate"][0]) -> list[Patch]:
    """Handles of a legend for the outcomes that are present; ``best`` is the label of the best outcome."""
    labels, colours = zip(*OUTCOME_STYLES.values(), strict=True)
    labels = (best, *labels[1:])
    return [Patch(facecolor=colours[k], edgecolor="0.5", label=labels[k]) for k in np.unique(outcomes).astype(int)]


def legend(figure: Figure, outcomes: np.ndarray, cases: bool = True) -> None:
    """Draw the legend of :func:`outcome_map` below the panels, with the limit of stability if a panel has one."""
    limits = [Line2D([], [], label="linear limit of stability", **LIMIT)] * any(ax.lines for ax in figure.axes)
    handles = [*patches(outcomes), *limits]
    for case in PAPER_CASES if cases else ():
        handles.append(Line2D([], [], marker=case.marker, linestyle="", color="black", markersize=6, label=case.title))
    legend_below(figure, columns=4, handles=handles)
