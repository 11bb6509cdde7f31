"""The reference of the interface: a page for each group of public names, as the docstring of ``study`` groups them."""

import inspect
import re
from collections.abc import Mapping
from types import ModuleType

import study
from docs.docstrings import escaped, explained, plain
from study.problem.named import makers
from study.registry import Registry

#: Public names of the introduction, before the first group.
RUNNING = "Running a scheme"
#: Modules that are meant for users.
_MODULES = {"materials", "settings"}


def public_names() -> list[str]:
    """Every public name: what ``study`` imports under a name without underscore, and the modules it speaks of."""
    return [
        name
        for name, value in vars(study).items()
        if not name.startswith("_") and (name in _MODULES or not isinstance(value, ModuleType))
    ]


def groups() -> dict[str, list[str]]:
    """The public names by group; each stands in the first group of the docstring that names it."""
    introduction, *sections = re.split(r"\n(?=[A-Z][^\n]*\n    )", inspect.getdoc(study) or "")
    texts = {RUNNING: introduction} | dict(section.split("\n", 1) for section in sections)
    found: dict[str, list[str]] = {}
    left = public_names()
    for title, text in texts.items():
        named = dict.fromkeys(re.findall(r"``(\w+)``", text))
        found[title] = [name for name in named if name in left]
        left = [name for name in left if name not in found[title]]
    found[RUNNING] += left
    return found


def file_of(title: str) -> str:
    """Name of the page of a group."""
    return title.lower().replace(" ", "_")


def _definition(problem: str) -> list[str]:
    """Equations, parameters and sources of a problem, a paragraph each within its entry."""
    known = explained(makers[problem])
    said = [known.summary, *(" ".join(lines) for lines in known.paragraphs), *known.references]
    return [part for text in said if text for part in ("", f"     {escaped(plain(text))}")] + [""]


def _registry(name: str, entries: Mapping) -> str:
    lines = [f".. py:data:: study.{name}", "", f"   A mapping from names to {name}. It holds:", ""]
    for key in entries:
        if name == "schemes":
            lines.append(f"   - :doc:`{key} </schemes/{key}>`, {entries[key].title}")
        else:
            said = (
                (inspect.getdoc(entries[key]) or "").splitlines()[:1] if name == "observers" else [entries[key].title]
            )
            lines.append(f"   - ``{key}``, {escaped(said[0]).rstrip('.') if said else ''}")
            lines += _definition(key) if name == "problems" else []
    return "\n".join(lines)


def _documented(name: str) -> str:
    value = getattr(study, name)
    if isinstance(value, Registry):
        return _registry(name, value)
    if isinstance(value, ModuleType):
        return f".. automodule:: {value.__name__}\n   :members:"
    if isinstance(value, type):
        return f".. autoclass:: study.{name}\n   :members:"
    if callable(value):
        return f".. autofunction:: study.{name}"
    return f".. py:data:: study.{name}\n\n   {', '.join(f'``{one}``' for one in value)}"


def pages() -> dict[str, str]:
    """Pages in reStructuredText by their file names; ``index`` leads to the others."""
    found = {}
    for title, names in groups().items():
        listed = ", ".join(f"``study.{name}``" for name in names)
        head = f".. meta::\n   :description: Reference of study: {title.lower()}: {', '.join(names)}.\n"
        line = "=" * len(title)
        found[file_of(title)] = "\n\n".join([head, f"{title}\n{line}", f"{listed}.", *map(_documented, names), ""])
    index = "\n".join(
        [
            ".. meta::\n   :description: Every public name of the package study, with its parameters and results.\n",
            "Interface",
            "=========",
            "",
            "Every public name of ``study``, by what it is for. ``help(study)`` gives the same tour in a terminal.",
            "",
            *(
                f"- :doc:`{file_of(title)}`: {', '.join(f'``{name}``' for name in names)}"
                for title, names in groups().items()
            ),
            "",
            ".. toctree::",
            "   :hidden:",
            "",
            *(f"   {file_of(title)}" for title in groups()),
            "",
        ]
    )
    return found | {"index": index}
