"""Docstrings of the code as text for pages: their equations, lists and references."""

import inspect
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

from numpydoc.docscrape import NumpyDocString

#: An ordinary word, which no left side of an equation has.
_WORD = re.compile(r"[A-Za-z]{4,}")
#: End of a reference: a page, a year or a section. A line may also end with an abbreviation.
_END_OF_REFERENCE = re.compile(r"\d\.$")
#: A role of reStructuredText, such as :class:`study.Scheme` or :func:`~study.run`.
_ROLE = re.compile(r":(\w+):`~?([\w.]+)`")


class Explained(NamedTuple):
    """What the docstring of a class says.

    Attributes
    ----------
    summary
        The first sentence.
    paragraphs
        The paragraphs after it, each as its lines.
    parameters
        Names of parameters and what is said of them.
    references
        One text for each work.
    """

    summary: str
    paragraphs: list[list[str]]
    parameters: dict[str, str]
    references: list[str]


def is_equation(paragraph: list[str]) -> bool:
    """Whether every line of a paragraph is an equation: before its first sign of equality stands no ordinary word."""
    signs = (re.split("[=←]", line, maxsplit=1) for line in paragraph)
    return all(len(sides) == 2 and not _WORD.search(sides[0]) for sides in signs)


def paragraphs_of(lines: Iterable[str]) -> list[list[str]]:
    """The lines between empty lines; equations after a colon are a paragraph of their own."""
    found: list[list[str]] = [[]]
    for line in lines:
        if not line.strip() or (found[-1] and found[-1][-1].endswith(":") and is_equation([line])):
            found.append([])
        if line.strip():
            found[-1].append(line)
    return [paragraph for paragraph in found if paragraph]


def references_of(lines: Iterable[str]) -> list[str]:
    """The works that a section of references lists one after the other."""
    found: list[list[str]] = [[]]
    for line in filter(None, (line.strip() for line in lines)):
        found[-1].append(line)
        if _END_OF_REFERENCE.search(line):
            found.append([])
    return [" ".join(work) for work in found if work]


def explained(documented: Callable) -> Explained:
    """The parts of the docstring of a class or a function."""
    parsed = NumpyDocString(inspect.getdoc(documented) or "")
    return Explained(
        " ".join(parsed["Summary"]),
        paragraphs_of(parsed["Extended Summary"]),
        {one.name: " ".join(one.desc) for one in parsed["Parameters"]},
        references_of(parsed["References"]),
    )


def plain(text: str) -> str:
    """A line of a docstring with names in place of roles."""
    return _ROLE.sub(r"\2", text)


def markdown(text: str) -> str:
    """A line of a docstring as Markdown: names in roles become code, and signs of Markdown are kept as they are."""
    text = _ROLE.sub(lambda role: f"``{role[2]}``", text)
    parts = re.split(r"(``.*?``)", text)  # code stays as it is
    text = "".join(part if part.startswith("``") else re.sub(r"([*_<\[\]|\\])", r"\\\1", part) for part in parts)
    return re.sub(r"^(\s*)([>#+])", r"\1\\\2", text)  # no quotation, heading or list


def restructured(lines: list[str]) -> list[str]:
    """A docstring for autodoc: equations line by line, references as a list, and bars as signs of their own."""
    found: list[str] = []
    section = ""
    for paragraph in paragraphs_of(lines):
        if len(paragraph) > 1 and set(paragraph[1].strip()) == {"-"}:
            section = paragraph[0].strip()
        if section == "References" and not paragraph[0].startswith((".. ", "[")):
            head = paragraph[:2] if paragraph[0].strip() == section else []
            # the backslash keeps an initial from being the letter of a list
            found += [*head, *(f"- \\{escaped(work)}" for work in references_of(paragraph[len(head) :])), ""]
        elif section == "Examples":
            found += [*paragraph, ""]
        elif is_equation(paragraph):
            found += [".. rst-class:: equations", "", *(f"| {escaped(line)}" for line in paragraph), ""]
        else:
            found += [*map(escaped, paragraph), ""]
    return found


def escaped(line: str) -> str:
    """Signs outside of code that reStructuredText would read as substitutions, emphasis and links, made plain."""
    parts = re.split(r"(``.*?``|:\w+:`.*?`)", line)
    return "".join(part if part.startswith(("``", ":")) else re.sub(r"([|*]|_\b)", r"\\\1", part) for part in parts)
