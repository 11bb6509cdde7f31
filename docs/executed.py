"""Pages whose numbers come from the datasets.

The Python of some pages runs when the site is built, and its output follows each block. In any page the role ``eval``
prints the value of an expression. The expression may use the names that the Python of the page defines, the numbers
``n`` of the article, and the functions ``listed``, ``number`` and ``percent`` of :mod:`study.words`.
"""

import contextlib
import io
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxRole

from docs.plan import NUMBERS
from study.io import read
from study.words import listed, number, percent

#: A block of Python.
CODE = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_KEY = "names of expressions"
#: Pages whose Python runs, by the beginnings of their names. ``_NOT_EXECUTED`` is excluded, because this page prints
#: times, which differ in each build.
_EXECUTED, _NOT_EXECUTED = ("index", "gallery/", "how_to/"), "how_to/speed"


def run(text: str, results: Path) -> tuple[str, dict[str, Any]]:
    """Run the Python of a page in the folder that contains ``results``; return the page with output, and all names."""
    names = {"listed": listed, "number": number, "percent": percent, "n": read(results / NUMBERS)}

    def with_output(block: re.Match) -> str:
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(block[1], names)
        return block[0] + (f"\n\n```text\n{printed.getvalue()}```" if printed.getvalue() else "")

    with contextlib.chdir(results.parent):  # `study.open_dataset` reads the folder `results`
        return CODE.sub(with_output, text), names


def _warn(subject: str, error: Exception, location: Any) -> None:
    logging.getLogger(__name__).warning(
        "%s fails with %r. If a dataset lacks a scheme or a problem, make the study of config/study.yaml.",
        subject,
        error,
        location=location,
    )


class Eval(SphinxRole):
    """The role ``eval``, which prints the value of an expression."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Evaluate the expression; an error is a warning, which fails the build."""
        names = self.env.current_document[_KEY]
        try:
            value = self.text if names is None else eval(self.text, names)
        except Exception as error:  # an expression may raise anything
            _warn(f"'{self.text}'", error, self.get_location())
            value = self.text
        return [nodes.Text(str(value))], []


def _before_page(app: Any, docname: str, source: list[str]) -> None:
    executed = docname.startswith(_EXECUTED) and docname != _NOT_EXECUTED
    try:
        text, names = run(source[0] if executed else "", app.srcdir.parent / "results")
        app.env.current_document[_KEY] = names
        source[0] = text or source[0]
    except Exception as error:  # a page may raise anything
        _warn("The Python of the page", error, docname)
        app.env.current_document[_KEY] = None


def setup(app: Any) -> None:
    """Register the role ``eval``, and run the Python of the executed pages before Sphinx reads their text."""
    app.add_role("eval", Eval())
    app.connect("source-read", _before_page)
