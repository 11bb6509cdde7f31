"""Common style of the figures: widths, panels, one style for each scheme everywhere, and how figures are saved."""

import os
import textwrap
from collections.abc import Callable, Iterable
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any
from zlib import crc32

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.scale import LogScale, register_scale
from matplotlib.ticker import LogFormatterSciNotation, NullFormatter

from paper.data import families
from paper.points import points
from study.io import write

plt.style.use("paper.figures.style")

#: Width in cm of a figure in one column of the manuscript, and of a figure across the page.
COLUMN, PAGE = 8.4, 17.4
_CM = 1 / 2.54

#: Label and colour of each outcome of a run, by its name in the maps of stability. Worse outcomes are darker, and all
#: colours differ in greyscale.
OUTCOME_STYLES = {
    "accurate": ("accurate", "#ffffff"),
    "bounded": ("bounded", "#cbdff2"),
    "damped_to_rest": ("damped to rest", "#84c0e2"),
    "in_the_wrong_well": ("in the wrong well", "#cc8c11"),
    "chaotic": ("chaotic", "#bd519f"),
    "growing": ("growing", "#b22c0e"),
    "beyond_the_limit": ("beyond the limit of stability", "#6e3a1a"),
    "no_solution_found": ("no solution found", "#40135f"),
    "unbounded": ("unbounded", "#000000"),
}

#: Ends of the logarithmic axes whose labels are plain numbers, not powers of ten.
_PLAIN = (1e-4, 1e5)
#: Size of an exponent over the size of its base.
_EXPONENT = 0.7

#: Maximum number of characters in a line of the legend of a family, and of curves of a family in a panel.
ENTRY, MOST = 14, 6

_COLOURS = ["#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7A1F4B"]
_LINES = ["-", "--", "-.", ":", (0, (7, 1.5)), (0, (3, 1, 1, 1, 1, 1)), (0, (1, 0.6))]
_MARKERS = ["o", "s", "v", "^", "D", "P", "X", "<"]

#: Numbers of the curve styles of each family, in the order of its schemes. The first eight schemes of a family have
#: different colours.
_STYLE_NUMBERS = {
    "Newmark and Wilson": (0, 1, 2, 3, 21, 23, 36, 38),
    "Multi-step and composite": (4, 8, 9, 10, 11, 14, 37, 39, 52, 49),
    "α-methods": (5, 17, 16, 15, 34, 43, 44, 46),
    "Runge-Kutta and conserving": (6, 19, 13, 12, 24, 25, 7, 42),
    "Explicit with dissipation": (29, 30, 26, 27, 20, 40, 41, 47, 50, 53),
    "Splitting": (28, 32, 18, 63, 22, 35, 33, 45),
}


class _LogLabels(LogFormatterSciNotation):
    """Labels of a logarithmic axis: plain numbers where they are short, otherwise powers with legible exponents."""

    def format_ticks(self, values: list[float]) -> list[str]:
        axis: Any = self.axis
        labels, (low, high) = super().format_ticks(values), sorted(axis.get_view_interval())
        plain = _PLAIN[0] < low and high < _PLAIN[1]
        size, name = plt.rcParams["font.size"], axis.axis_name
        # panels with a common axis share this object, which belongs to the axis of one of them
        shared = getattr(axis.axes, f"get_shared_{name}_axes")()
        for axes in shared.get_siblings(axis.axes):
            axes.tick_params(name, which="both", labelsize=size if plain else size / _EXPONENT)
        return [f"{value:g}" if plain and label else label for value, label in zip(values, labels, strict=True)]


class _Log(LogScale):
    """Logarithmic scale of all figures, with the labels of :class:`_LogLabels`."""

    # only before its version 3.11 does Matplotlib pass the axis
    def __init__(self, *axes: Axis, **options: Any):
        super().__init__(*axes, **options)

    def set_default_locators_and_formatters(self, axis: Axis) -> None:
        super().set_default_locators_and_formatters(axis)
        axis.set_major_formatter(_LogLabels(self.base))
        axis.set_minor_formatter(_LogLabels(self.base, labelOnlyBase=False))


register_scale(_Log)


def curve_styles(schemes: xr.DataArray) -> dict[str, dict[str, Any]]:
    """One style (colour, line style, marker) for each scheme of a dataset, the same in every figure.

    The style follows from the family of a scheme and its place among all schemes of the family.
    """
    places = zip(*(schemes[name].values.tolist() for name in ("scheme", "family", "place_in_family")), strict=True)
    return {name: _curve_style(_number(family, place)) for name, family, place in places}


def curve_styles_in_order(names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """One style for each of some curves, by their order in the figure and not by family."""
    return {name: _curve_style(index) for index, name in enumerate(names)}


def _number(family: str, place: int) -> int:
    known = _STYLE_NUMBERS.get(family, ())
    return known[place] if place < len(known) else 56 + 8 * (crc32(family.encode()) % 50) + place


def _curve_style(number: int) -> dict[str, Any]:
    turn, place = divmod(number, len(_COLOURS))
    return {
        "color": _COLOURS[place],
        "linestyle": _LINES[(place + 2 * turn) % len(_LINES)],
        "marker": _MARKERS[(place + 3 * turn) % len(_MARKERS)],
    }


def thinned(widest: float, by: float, index: int) -> float:
    """Width of a curve that is drawn over ``index`` thicker ones, so that coinciding curves are all visible."""
    return max(widest - by * index, 0.5)


def panels(rows: int, columns: int, width: float, height: float, **options: Any) -> tuple[Figure, np.ndarray]:
    """A figure of a given size in cm, and its panels by row and column."""
    return plt.subplots(rows, columns, figsize=(width * _CM, height * _CM), squeeze=False, **options)


def empty(width: float, height: float) -> Figure:
    """A figure of a given size in cm, without panels."""
    return plt.figure(figsize=(width * _CM, height * _CM))


def wrapped(title: str, width: int) -> str:
    """A title in lines of limited length, without a break around an equals sign or after the word "order"."""
    kept = title.replace(" = ", "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}").replace("order ", "order\N{NO-BREAK SPACE}")
    return textwrap.fill(kept, width)


def whole_decades(axes: Axes) -> None:
    """End a logarithmic x-axis at powers of ten, and label only these."""
    low, high = np.log10(axes.get_xlim())
    axes.set_xlim(10.0 ** np.floor(low), 10.0 ** np.ceil(high))
    axes.xaxis.set_minor_formatter(NullFormatter())


def letter(axes: Axes, index: int, title: str) -> None:
    """Set the title of a panel: its letter, (a), (b), ..., (z), (aa), ..., and what the panel shows."""
    turn, place = divmod(index, 26)
    axes.set_title(f"({chr(ord('a') + place) * (turn + 1)}) {title}")


def legend_below(figure: Figure, columns: int, axes: Axes | None = None, handles: list | None = None) -> None:
    """Draw a legend of ``handles`` below all panels, by default of the curves of ``axes`` or of the first panel."""
    handles = (axes or figure.axes[0]).get_legend_handles_labels()[0] if handles is None else handles
    figure.legend(handles=handles, loc="outside lower center", ncols=min(columns, max(len(handles), 1)))


def legend_in_gap(figure: Figure, axes: np.ndarray, number: int, columns: int) -> None:
    """Draw a legend in place of the panels after the first ``number``; without such panels, below all panels."""
    if number == axes.size:
        legend_below(figure, columns)
        return
    place, *others = axes.ravel()[number:]
    for unused in others:
        unused.remove()
    place.axis("off")
    handles = axes.flat[0].get_legend_handles_labels()[0]
    place.legend(handles=handles, loc="center left", borderaxespad=0, handlelength=2.2)


def figure_of_families(
    dataset: xr.Dataset, rows: int, height: float
) -> tuple[Figure, list[tuple[xr.Dataset, np.ndarray]]]:
    """A figure as wide as the page: a column of panels for each family, and a place for a legend below each column.

    A family has the first ``MOST`` of its schemes in the dataset.

    Parameters
    ----------
    rows, height
        Number of panels in a column, and the height of a panel in cm.

    Returns
    -------
    figure, columns
        The figure, and a pair for each family: its part of the dataset, and an array of its panels from top to bottom
        with the place of its legend last.
    """
    parts = {name: part.isel(scheme=slice(MOST)) for name, part in families(dataset).items()}
    entries = [[wrapped(title, ENTRY) for title in part.scheme_title.values] for part in parts.values()]
    legend = max(0.08 * len(titles) + 0.31 * sum(title.count("\n") + 1 for title in titles) for titles in entries)
    figure = empty(PAGE, rows * (height + 0.3) + legend + 1.95)  # with room for titles and labels
    grid = figure.add_gridspec(rows + 1, len(parts), height_ratios=[height] * rows + [legend])
    columns: list[tuple[xr.Dataset, np.ndarray]] = []
    for index, (name, part) in enumerate(parts.items()):
        axes: list[Axes] = []
        for row in range(rows):
            first = columns[0][1][row] if columns else None
            axes.append(figure.add_subplot(grid[row, index], sharex=axes[0] if axes else first, sharey=first))
            axes[-1].tick_params(labelleft=first is None, labelbottom=row == rows - 1)
        below = figure.add_subplot(grid[rows, index])
        below.axis("off")
        letter(axes[0], index, wrapped(name, 14))
        columns.append((part, np.array([*axes, below])))
    return figure, columns


def legend_in(place: Axes, axes: Axes) -> None:
    """Draw a legend of the curves of a panel, in one column, in the place reserved for it."""
    handles, titles = axes.get_legend_handles_labels()
    titles = [wrapped(title, ENTRY) for title in titles]
    legend = place.legend(
        handles, titles, loc="upper left", borderaxespad=0, handlelength=2.2, bbox_to_anchor=(-0.1, 1.0)
    )
    legend.set_in_layout(False)  # long entries do not narrow the column


def save(figure: Figure, output: Path) -> None:
    """Save a figure as PDF, PNG and SVG, and its points as CSV, next to ``output``, with equal bytes for equal data."""
    # The layout takes as long as drawing, so all three files share one layout. Each canvas prints directly, because
    # figure.savefig would draw twice.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    os.environ.setdefault("SOURCE_DATE_EPOCH", "0")
    printers: dict[str, Callable[[BytesIO], None]] = {
        ".pdf": FigureCanvasPdf(figure).print_pdf,
        ".png": FigureCanvasAgg(figure).print_png,
        ".svg": partial(FigureCanvasSVG(figure).print_svg, metadata={"Date": None}),
    }
    for suffix, printer in printers.items():
        figure.dpi = plt.rcParams["savefig.dpi"]  # resolution of rasters; printing PDF or SVG resets it
        content = BytesIO()
        printer(content)
        write(content.getvalue(), output.with_suffix(suffix))
    write(points(figure).to_csv(index=False, float_format="%.7g"), output.with_suffix(".csv"))


def at_width(figure: Figure, millimetres: float) -> Figure:
    """The figure with another width, which its panels fill. Its height and the size of its text remain."""
    figure.set_figwidth(millimetres / 10 * _CM)
    return figure
