"""Pages whose numbers come from the datasets.

The Python of a page of the gallery runs when the site is built. In any page the role ``eval`` is the value of an
expression in the names that this Python defines, in ``n``, the numbers of the article, and in functions of
:mod:`docs.text`.
"""

import contextlib
import json
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging
from sphinx.util.docutils import SphinxRole

from docs.plan import NUMBERS
from study.words import listed, number, percent

_CODE = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_KEY = "names of expressions"


def names_of(text: str, results: Path) -> dict[str, Any]:
    """Names for the expressions of a page, whose Python runs next to a folder of results."""
    n = json.loads((results / NUMBERS).read_text(encoding="utf-8"))
    names = {"listed": listed, "number": number, "percent": percent, "n": n}
    with contextlib.chdir(results.parent):  # `study.open_dataset` reads the folder `results`
        for code in _CODE.findall(text):
            exec(code, names)
    return names


def _warn(what: str, error: Exception, location: Any) -> None:
    logging.getLogger(__name__).warning(
        "%s fails with %r; if a dataset lacks what it needs, make the study of config/study.yaml or a larger one.",
        what,
        error,
        location=location,
    )


class Eval(SphinxRole):
    """The value of an expression."""

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
    code = source[0] if docname.startswith("gallery/") else ""
    try:
        app.env.current_document[_KEY] = names_of(code, app.srcdir.parent / "results")
    except Exception as error:  # a page may raise anything
        _warn("The Python of the page", error, docname)
        app.env.current_document[_KEY] = None


def setup(app: Any) -> None:
    """Register the role, and run the Python of a page before its text is read."""
    app.add_role("eval", Eval())
    app.connect("source-read", _before_page)
