"""The points of a figure as a table, for readers who draw it again."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, QuadMesh
from matplotlib.figure import Figure

#: Columns of the table: title of the panel, label of the curve, coordinates, and value of a cell of a map.
COLUMNS = ["panel", "curve", "x", "y", "value"]


def _parts(axes: Axes) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Label, x, y and value of the points of each curve, interval, scatter and map; only maps have values."""
    for line in axes.lines:
        # a line across a panel has coordinates of the panel
        if line.get_transform() == axes.transData:
            x, y = (np.ravel(np.asarray(one, float)) for one in line.get_data(orig=False))
            yield str(line.get_label()), x, y, np.full(x.shape, np.nan)
    for one in axes.collections:
        if isinstance(one, PathCollection):
            x, y = np.ma.filled(np.ma.asarray(one.get_offsets(), float), np.nan).T
            yield str(one.get_label()), x, y, np.full(x.shape, np.nan)
        elif isinstance(one, LineCollection) and one.get_transform() == axes.transData:
            # the ends of intervals, of which there may be none, or one without ends
            x, y = np.concatenate([np.empty((0, 2)), *(np.reshape(ends, (-1, 2)) for ends in one.get_segments())]).T
            yield str(one.get_label()), x, y, np.full(x.shape, np.nan)
        elif isinstance(one, QuadMesh):
            corners = np.asarray(one.get_coordinates())
            x, y = (corners[:-1, :-1] + corners[1:, 1:]).reshape(-1, 2).T / 2
            yield "", x, y, np.ma.filled(np.ma.asarray(one.get_array(), float), np.nan).ravel()
    for image in axes.images:
        cells: np.ndarray = np.ma.filled(np.ma.asarray(image.get_array(), float), np.nan)
        if cells.ndim == 2:
            left, right, bottom, top = image.get_extent()
            if image.origin == "upper":
                bottom, top = top, bottom
            rows, columns = ((np.arange(size) + 0.5) / size for size in cells.shape)
            x, y = np.meshgrid(left + (right - left) * columns, bottom + (top - bottom) * rows)
            yield "", x.ravel(), y.ravel(), cells.ravel()


def points(figure: Figure) -> pd.DataFrame:
    """The points of all curves, intervals, scatters and maps, a row for each point, with the columns ``COLUMNS``.

    A panel has its title, or its number if it has none; a curve has its label in the legend, which may be empty.
    """
    parts = [
        pd.DataFrame({"panel": axes.get_title("left") or axes.get_title() or str(place), "curve": label, **numbers})
        for place, axes in enumerate(figure.axes, start=1)
        for label, x, y, value in _parts(axes)
        for numbers in [{"x": x, "y": y, "value": value}]
    ]
    found = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=COLUMNS)
    found["curve"] = found.curve.where(~found.curve.astype(str).str.startswith("_"), "")
    found["panel"] = found.panel.str.replace("\n", " ")
    return found.dropna(axis="columns", how="all") if parts else found
