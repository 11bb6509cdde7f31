"""The points of a figure as a table, for readers who draw it again."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection, PathCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.container import Container, ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator

#: Columns of the table: title of the panel, label of the curve, coordinates, value of a cell of a map, and names of the
#: coordinates along an axis of names.
COLUMNS = ["panel", "curve", "x", "y", "value", "x name", "y name"]


def _look(artist: Artist | Container) -> tuple[str, ...]:
    """Colour and marker of a curve, or colour of intervals, which a legend names; empty for other artists."""
    line = artist[0] if isinstance(artist, ErrorbarContainer) else artist
    if isinstance(line, LineCollection):
        return tuple(sorted({to_hex(colour) for colour in np.atleast_2d(line.get_color())}))
    return (to_hex(line.get_color()), str(line.get_marker())) if isinstance(line, Line2D) else ()


def _legend(figure: Figure) -> dict[tuple[str, ...], str]:
    """The label of each look of a curve that only one label has."""
    legends = [legend for legend in (*figure.legends, *(axes.get_legend() for axes in figure.axes)) if legend]
    pairs: list[tuple[Any, str]] = [
        pair for axes in figure.axes for pair in zip(*axes.get_legend_handles_labels(), strict=True)
    ]
    for legend in legends:
        pairs += zip(legend.legend_handles, (text.get_text() for text in legend.get_texts()), strict=True)
    labels: dict[tuple[str, ...], set[str]] = {}
    for artist, label in pairs:
        if look := _look(artist):
            for known in (look, look[:1]):
                labels.setdefault(known, set()).add(label)
    return {look: label for look, (label, *others) in labels.items() if not others}


def _names(axis: Axis, values: np.ndarray) -> np.ndarray | float:
    """Names of coordinates along an axis whose ticks 0, 1, 2, … have names; NaN along other axes."""
    places = axis.get_majorticklocs()
    if not (isinstance(axis.get_major_locator(), FixedLocator) and np.array_equal(places, np.arange(len(places)))):
        return np.nan
    names = [*axis.get_major_formatter().format_ticks(places.tolist()), ""]
    if not any(character.isalpha() for name in names for character in name):
        return np.nan
    return np.array(names, object)[np.where(np.isfinite(values), np.rint(values), -1).astype(int)]


def _parts(axes: Axes, legend: dict[tuple[str, ...], str]) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Label, x, y and value of the points of each curve, interval, scatter and map; only maps have values."""

    def name(artist: Artist) -> str:
        label = str(artist.get_label())
        return legend.get(_look(artist), "") if label.startswith("_") else label

    for line in axes.lines:
        # a line across a panel has coordinates of the panel
        if line.get_transform() == axes.transData:
            x, y = (np.ravel(np.asarray(coordinates, float)) for coordinates in line.get_data(orig=False))
            yield name(line), x, y, np.full(x.shape, np.nan)
    for collection in axes.collections:
        if isinstance(collection, PathCollection):
            x, y = np.ma.filled(np.ma.asarray(collection.get_offsets(), float), np.nan).T
            yield name(collection), x, y, np.full(x.shape, np.nan)
        elif isinstance(collection, LineCollection) and collection.get_transform() == axes.transData:
            # the ends of intervals, of which there may be none, or one without ends
            x, y = np.concatenate(
                [np.empty((0, 2)), *(np.reshape(ends, (-1, 2)) for ends in collection.get_segments())]
            ).T
            yield name(collection), x, y, np.full(x.shape, np.nan)
        elif isinstance(collection, QuadMesh):
            corners = np.asarray(collection.get_coordinates())
            x, y = (corners[:-1, :-1] + corners[1:, 1:]).reshape(-1, 2).T / 2
            yield "", x, y, np.ma.filled(np.ma.asarray(collection.get_array(), float), np.nan).ravel()
    for image in axes.images:
        cells: np.ndarray = np.ma.filled(np.ma.asarray(image.get_array(), float), np.nan)
        if cells.ndim == 2:
            left, right, bottom, top = image.get_extent()
            if image.origin == "upper":
                bottom, top = top, bottom
            rows, columns = ((np.arange(size) + 0.5) / size for size in cells.shape)
            places = np.meshgrid(left + (right - left) * columns, bottom + (top - bottom) * rows)
            # an image may lie in the coordinates of the panel
            x, y = (image.get_transform() - axes.transData).transform(np.reshape(places, (2, -1)).T).T
            yield "", x, y, cells.ravel()


def points(figure: Figure) -> pd.DataFrame:
    """The points of all curves, intervals, scatters and maps, a row for each point, with the columns ``COLUMNS``.

    A panel has its label, its title, or its number if it has neither. A curve has its label, or that of the legend for
    its colour and marker, which may be empty. A coordinate has the name that the axis gives it, if any.
    """
    legend = _legend(figure)
    parts = [
        pd.DataFrame({"panel": axes.get_label() or axes.get_title("left") or axes.get_title() or str(place), **numbers})
        for place, axes in enumerate(figure.axes, start=1)
        for label, x, y, value in _parts(axes, legend)
        for names in [{"x name": _names(axes.xaxis, x), "y name": _names(axes.yaxis, y)}]
        for numbers in [{"curve": label, "x": x, "y": y, "value": value, **names}]
    ]
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=COLUMNS)
    table["panel"] = table.panel.str.replace("\n", " ")
    return table.dropna(axis="columns", how="all") if parts else table
