"""Curves and maps as SVG that stands in a page: its text and lines take the colours of the page, light or dark."""

import html
import io
import re

from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from paper.figures.style import OUTCOME_STYLES  # whose settings hold for these figures too

#: Colours that a page replaces by its own, see ``static/site.css``: of text and lines, of what stands out, of others.
INK, ACCENT, OTHER = "#000000", "#0072b2", "#999999"
_NAMES = {INK: "currentColor", ACCENT: "var(--curve)", OTHER: "var(--curve-other)"}

#: Width and height of a panel in inches.
PANEL = (3.5, 2.7)

_SETTINGS = {"font.family": ["DejaVu Sans", "sans-serif"], "font.size": 9, "svg.fonttype": "none"}


def panel(width: float = PANEL[0], height: float = PANEL[1]) -> tuple[Figure, Axes]:
    """A figure with one panel, which a page sets beside others where it has room."""
    with rc_context(_SETTINGS):
        figure = Figure(figsize=(width, height), facecolor="none")
        axes = figure.subplots()
        axes.set_facecolor("none")
        axes.grid(color=OTHER, linewidth=0.3, alpha=0.6)
        axes.set_axisbelow(True)
        return figure, axes


def svg(figure: Figure, label: str) -> str:
    """A figure as an element of a page, the same for the same data.

    Parameters
    ----------
    label
        What it shows, for those who do not see it.
    """
    with rc_context(_SETTINGS | {"svg.hashsalt": rcParams["svg.hashsalt"]}):
        written = io.StringIO()
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = written.getvalue()
    text = text[text.index("<svg") :].strip()
    text = re.sub(r"\s*<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r' (width|height)="[\d.]+pt"', "", text, count=2)
    for colour, name in _NAMES.items():
        text = re.sub(rf"(fill|stroke): {colour}\b", rf"\1: {name}", text)
    text = text.replace("<svg", f'<svg role="img" aria-label="{html.escape(label)}"', 1)
    # an empty line would end the element for Markdown
    return re.sub(r"\n\s*\n", "\n", text)


def figure_of(panels: list[str], caption: str) -> str:
    """Panels with one caption, as an element of a page."""
    inside = "\n".join(f'<div class="panel">{one}</div>' for one in panels)
    return f'<figure class="panels">\n{inside}\n<figcaption>{caption}</figcaption>\n</figure>\n'


def map_legend() -> str:
    """The colours of outcomes in the maps, as an element of a page."""
    colours = "\n".join(
        f'<li><span style="background: {colour}"></span>{label}</li>' for label, colour in OUTCOME_STYLES.values()
    )
    return f'<ul class="outcomes">\n{colours}\n</ul>'
