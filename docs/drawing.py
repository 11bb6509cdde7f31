"""Curves and maps as SVG elements of a page; text and lines have the colours of the page, light or dark."""

import html
import io
import math
import re
from typing import Any

from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from paper.figures.style import OUTCOME_STYLES  # importing this module sets the style of these figures too
from study.words import RAISED

#: Colours of text and axes, of the highlighted curve, and of other curves. :func:`svg` replaces them by the colours of
#: the page, which ``static/site.css`` defines.
INK, ACCENT, OTHER = "#000000", "#0072b2", "#999999"
_NAMES = {INK: "currentColor", ACCENT: "var(--curve)", OTHER: "var(--curve-other)"}

#: Width and height of a panel in inches.
PANEL = (3.5, 2.7)

_SETTINGS: Any = {"font.family": ["DejaVu Sans", "sans-serif"], "font.size": 9, "svg.fonttype": "none"}


def panel(logarithmic: str = "") -> tuple[Figure, Axes]:
    """A figure with one panel, and its axes. A wide page shows several panels side by side.

    Parameters
    ----------
    logarithmic
        Names of the logarithmic axes: "x", "y", "xy", or "" if no axis is logarithmic.
    """
    with rc_context(_SETTINGS):
        # fixed margins, because a layout that measures all texts would take most of the time
        figure = Figure(figsize=PANEL, facecolor="none")
        figure.set_layout_engine("none")
        axes = figure.add_axes((0.17, 0.18, 0.8, 0.72))
        axes.set_facecolor("none")
        for name in logarithmic:
            axes.set(**{f"{name}scale": "log"})
            axis = getattr(axes, f"{name}axis")
            # labels such as 10⁻² are plain text: mathematical typesetting would take longer than the rest
            axis.set_major_formatter(lambda value, _: "10" + str(round(math.log10(value))).translate(RAISED))
            axis.set_minor_formatter(NullFormatter())
        axes.grid(color=OTHER, linewidth=0.3, alpha=0.6)
        axes.set_axisbelow(True)
        return figure, axes


def svg(figure: Figure, label: str) -> str:
    """A figure as an SVG element of a page; equal data give equal text.

    Parameters
    ----------
    label
        Description for screen readers.
    """
    with rc_context(_SETTINGS | {"svg.hashsalt": rcParams["svg.hashsalt"]}):
        written = io.StringIO()
        FigureCanvasSVG(figure).print_svg(written, metadata={"Date": None, "Creator": None})
    text = written.getvalue()
    text = text[text.index("<svg") :].strip()
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r' (width|height)="[\d.]+pt"', "", text, count=2)
    text = re.sub(r'<g id="[^"]*">', "<g>", text)  # identifiers would repeat within a page
    for colour, name in _NAMES.items():
        text = re.sub(rf"(fill|stroke): {colour}\b", rf"\1: {name}", text)
    text = text.replace("<svg", f'<svg role="img" aria-label="{html.escape(label)}"', 1)
    # an empty line would end the element for Markdown
    return re.sub(r"\n\s*\n", "\n", text)


def figure_of(panels: list[str], caption: str) -> str:
    """Panels with one caption, as an element of a page."""
    inside = "\n".join(f'<div class="panel">{element}</div>' for element in panels)
    return f'<figure class="panels">\n{inside}\n<figcaption>{caption}</figcaption>\n</figure>\n'


def lines_legend(lines: list[tuple[str, str]]) -> str:
    """A legend of line styles as an element of a page. The first line is the highlighted curve."""
    styles = {"-": "solid", "--": "dashed", ":": "dotted"}
    colours = ["var(--curve)"] + ["var(--curve-other)"] * (len(lines) - 1)
    items = "\n".join(
        f'<li><span style="border-top: 3px {styles[line]} {colour}"></span>{html.escape(label)}</li>'
        for colour, (line, label) in zip(colours, lines, strict=True)
    )
    return f'<ul class="outcomes lines">\n{items}\n</ul>'


def map_legend() -> str:
    """The colours of outcomes in the maps, as an element of a page."""
    colours = "\n".join(
        f'<li><span style="background: {colour}"></span>{label}</li>' for label, colour in OUTCOME_STYLES.values()
    )
    return f'<ul class="outcomes">\n{colours}\n</ul>'
