r"""Formulas as MathML, converted when the site is built, so that a page needs no script.

Equations of one block are separated by ``\\`` or by an empty line, and aligned at ``&``, as in the other renderers of
Sphinx.
"""

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.util import logging

#: Pattern of the converter's output for an unsupported command or sign.
_NOT_SET = re.compile(r"<mi>(\\\w+|&)</mi>")


def mathml(latex: str, display: str) -> str:
    """A formula as an element of a page.

    Parameters
    ----------
    display
        "inline" or "block".

    Raises
    ------
    ValueError
        If the formula has a command or a sign that the converter does not support.
    """
    latex = re.sub(r"\n\s*\n", r"\\\\", latex.strip())
    if display == "block" and r"\\" in latex and r"\begin" not in latex:
        latex = rf"\begin{{split}}{latex}\end{{split}}"
    element = convert(latex, display=display)
    if unknown := _NOT_SET.search(element):
        raise ValueError(f"the formula '{latex}' has '{unknown[1]}', which cannot be set as MathML.")
    return element


def _visit(display: str, before: str = "", after: str = "") -> tuple[Any, None]:
    def visit(writer: Any, node: nodes.Element) -> None:
        try:
            writer.body.append(f"{before}{mathml(node.astext(), display)}{after}")
        except ValueError as error:
            logging.getLogger(__name__).warning("%s", error, location=node)
        raise nodes.SkipNode

    return visit, None


def setup(app: Any) -> None:
    """Register the renderer of formulas."""
    app.add_html_math_renderer("mathml", _visit("inline"), _visit("block", '<div class="math">', "</div>\n"))
