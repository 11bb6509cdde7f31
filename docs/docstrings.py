"""Docstrings of the code for numpydoc: subscripts, and references as a list."""

import inspect
import re
from collections.abc import Iterable
from typing import Any

from numpydoc.docscrape_sphinx import SphinxDocString

#: Pattern of the end of a reference: the last digit of a page, a year or a section, and a full stop. A line that ends
#: with an abbreviation does not end the reference.
_END_OF_REFERENCE = re.compile(r"\d\.$")
_SUBSCRIPT = re.compile(r"([α-ωΩ])_(?:(\w+)|\{([^}]+)\})")


def references_of(lines: Iterable[str]) -> list[str]:
    """The works in a section of references, one text for each work. Empty lines are skipped."""
    works: list[list[str]] = [[]]
    for line in filter(None, (line.strip() for line in lines)):
        works[-1].append(line)
        if _END_OF_REFERENCE.search(line):
            works.append([])
    return [" ".join(work) for work in works if work]


def restructured(lines: Iterable[str]) -> list[str]:
    """A docstring as reStructuredText: α_m and similar symbols get a subscript, and the references become a list."""
    text, heading, works = "\n".join(lines).partition("References\n----------\n")
    text = _SUBSCRIPT.sub(r"\1\\ :sub:`\2\3`\\ ", text)
    # without the backslash the initial of an author would be read as the letter of a list
    listed = [f"- \\{work}" for work in references_of(works.splitlines())]
    return [*text.splitlines(), *heading.splitlines(), *listed, ""]


def parsed(documented: Any) -> SphinxDocString:
    """The docstring of a class or a function, parsed into sections. ``str`` of it is reStructuredText."""
    return SphinxDocString("\n".join(restructured((inspect.getdoc(documented) or "").splitlines())))
