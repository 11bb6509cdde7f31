"""Checks of printed figures for faults that a reader would notice."""

import itertools
import re
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from paper.figures.style import COLUMN, PAGE
from paper.products import content_of, discover, reader

#: Smallest font size in points, and largest overlap of two texts in points.
SMALLEST, SHARED = 7.0, 1.0
#: Largest number of curves in a panel of the article.
CURVES = 6
#: Largest height of a figure in cm, which leaves room for its caption on a page.
TALLEST = 19.5


class Printed(NamedTuple):
    """A text as it is drawn: its words, its smallest font size in points, and its bounding box in points."""

    words: str
    size: float
    place: Bbox


def _smallest(text: Text) -> float:
    """Smallest font size of a text in points, which is that of an exponent or index if its formulas have any."""
    formulas = [line for line in text.get_text().split("\n") if "$" in line]
    font = FontProperties(size=text.get_fontsize())
    glyphs = [glyph for line in formulas for glyph in MathTextParser("path").parse(line, 72, font).glyphs]
    return float(min([text.get_fontsize(), *(size for _, size, *_ in glyphs)]))


def printed(figure: Figure) -> list[Printed]:
    """All texts that are drawn, without hidden texts such as labels of ticks outside the limits."""
    figure.dpi = 72
    figure.draw_without_rendering()
    texts = []

    def draw(text, renderer, *args, **kwargs):
        # the box of an annotation is that of its words, without the arrow
        if text.get_visible() and text.get_text().strip():
            texts.append(Printed(text.get_text(), _smallest(text), Text.get_window_extent(text, renderer)))

    with mock.patch.object(Text, "draw", draw):
        figure.draw_without_rendering()
    return texts


def curves(axes: Axes) -> int:
    """Number of curves of a panel, with straight guides, but without markers alone and lines across the panel."""
    return sum(
        line.get_transform() == axes.transData
        and line.get_linestyle() not in ("None", "", " ")
        and np.isfinite(np.asarray(line.get_xydata())).all(axis=1).sum() > 1
        for line in axes.lines
    )


def _has_code(words: str) -> bool:
    """Whether a text has code outside formulas: an underscore, ``nan``, ``None``, ``inf``, or a number like 5e-05."""
    outside = re.sub(r"\$[^$]*\$", "", words)
    return bool(re.search(r"_|\b(nan|None|inf)\b|\de[-−+]?\d", outside))


def faults(figure: Figure) -> list[str]:
    """Sentences on faults of a figure: wrong size, texts that are too small, contain code, are cut off or overlap."""
    width, height = figure.get_size_inches() * 2.54
    messages = (
        [] if min(abs(width - COLUMN), abs(width - PAGE)) < 0.01 else [f"{width:.1f} cm is no width of the manuscript"]
    )
    messages += [f"{height:.1f} cm is too high"] if height > TALLEST else []
    texts = printed(figure)
    page = figure.bbox.padded(1)
    for text in texts:
        messages += [f"'{text.words}' has {text.size:.3g} pt"] if text.size < SMALLEST - 1e-6 else []
        messages += [f"'{text.words}' is of code"] if _has_code(text.words) else []
        inside = page.contains(*text.place.min) and page.contains(*text.place.max)
        messages += [] if inside else [f"'{text.words}' is cut off at {np.round(text.place.extents)} of {page.extents}"]
    for text, other in itertools.combinations(texts, 2):
        shared = Bbox.intersection(text.place, other.place)
        if shared is not None and min(shared.width, shared.height) > SHARED:
            messages.append(f"'{text.words}' and '{other.words}' overlap")
    return messages


def crowded(figure: Figure) -> list[str]:
    """Sentences on panels that have more curves than a panel of the article may have."""
    numbers = {axes.get_title("left"): curves(axes) for axes in figure.axes}
    return [f"'{title}' has {number} curves" for title, number in numbers.items() if number > CURVES]


def faults_of_all(results: Path, article: Collection[str] = ()) -> dict[str, list[str]]:
    """Draw all figures from a folder of results, and return the faults of the figures that have any.

    Figures of the ``article`` have a limited number of curves in each panel.
    """
    read, faults_by_figure = reader(results), {}
    for product in discover(["figures"]):
        if product.kind == "figure":
            picture = content_of(product, read)
            faults_by_figure[product.name] = faults(picture)
            if product.name in article:
                faults_by_figure[product.name] += crowded(picture)
            plt.close(picture)
    return {name: sentences for name, sentences in faults_by_figure.items() if sentences}
