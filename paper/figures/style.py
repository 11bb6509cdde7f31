"""Common style of the figures: size, type, colours that survive greyscale, and how figures are saved."""

import os
from collections.abc import Callable
from functools import partial
from io import BytesIO
from pathlib import Path

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from paper.data import families
from paper.writing import write

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

#: Label and colour of each outcome of a run, by its name in the maps of stability. Worse outcomes are darker, so that
#: the order survives greyscale.
OUTCOME_STYLES = {
    "accurate": ("accurate", "#ffffff"),
    "bounded": ("bounded", "#d0e1f2"),
    "damped_to_rest": ("damped to rest", "#8fc1e0"),
    "in_the_wrong_well": ("in the wrong well", "#e69f00"),
    "chaotic": ("chaotic", "#cc79a7"),
    "growing": ("growing", "#c8500a"),
    "newton_not_converged": ("Newton did not converge", "#7f1d2d"),
    "not_finite": ("not finite", "#000000"),
}

# Okabe and Ito's palette without its yellow; line styles and markers distinguish the curves without any colour.
_COLOURS = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"]
_LINES = ["-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1))]
_MARKERS = ["o", "s", "v", "^", "D", "P", "X"]

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
    """One look (colour, line style, marker) for each scheme, the same in every figure of the same schemes.

    The eighth curve takes the colour of the first with the next line style and another marker, and so on.
    """
    return {name: _look(index) for index, name in enumerate(schemes.values.tolist())}


def _look(index: int) -> dict:
    number = len(_COLOURS)
    turn = index // number
    return {
        "color": _COLOURS[index % number],
        "linestyle": _LINES[(index + turn) % number],
        "marker": _MARKERS[(index + 3 * turn + turn // number) % number],
    }


def thinned(widest: float, by: float, index: int) -> float:
    """Width of a curve that is drawn over ``index`` thicker ones, so that coinciding curves are all visible."""
    return max(widest - by * index, 0.5)


def legend_size(entries: int, most: int) -> float:
    """Size of the type in a legend with room for ``most`` entries of full size."""
    return plt.rcParams["legend.fontsize"] * min(1.0, most / max(entries, 1))


def legend_beside(axes: Axes) -> None:
    """A legend to the right of a panel, in smaller type if it has more than seven entries."""
    size = legend_size(len(axes.get_legend_handles_labels()[0]), most=7)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=3, fontsize=size)


def a_panel_for_each_family(dataset: xr.Dataset, height: float, **shared) -> tuple[Figure, dict[Axes, xr.Dataset]]:
    """A figure with two columns of panels, and the part of the dataset with the family of each panel."""
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
    """Title of a panel: (a), (b), ..., (z), (aa), ... and what it shows."""
    turn, place = divmod(index, 26)
    axes.set_title(f"({chr(ord('a') + place) * (turn + 1)}) {title}")


def save(figure: Figure, output: Path) -> None:
    """Save a figure as PDF, PNG and SVG next to ``output``, the same bytes for the same data."""
    # one layout for all three files, as it takes as long as drawing; for the same reason each canvas prints directly,
    # where figure.savefig would draw twice
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    printers: dict[str, Callable[[BytesIO], None]] = {
        ".pdf": FigureCanvasPdf(figure).print_pdf,
        ".png": FigureCanvasAgg(figure).print_png,
        ".svg": partial(FigureCanvasSVG(figure).print_svg, metadata={"Date": None}),
    }
    for suffix, printer in printers.items():
        figure.dpi = plt.rcParams["savefig.dpi"]  # for rasters; vectors reset it to points
        content = BytesIO()
        printer(content)
        write(output.with_suffix(suffix), content.getvalue())
