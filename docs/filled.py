"""Pages with numbers: their lines of code run on the datasets, and what the text says follows from them.

In the text of such a page ``{{expression}}`` is an expression of Python in the names that its lines of code define, and
an image ``figure:NAME`` is a figure of the study. A page that begins with its lines, as those of the gallery do, is
written with the answer first and the lines at its end.
"""

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docs.text import listed, number, percent

FOLDER = Path(__file__).parent / "pages"

_CODE = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_LINES_FIRST = re.compile(r"\A(# [^\n]*\n\n)(```python\n.*?^```\n)\n(.*)\Z", re.DOTALL | re.MULTILINE)
_EXPRESSION = re.compile(r"\{\{(.+?)\}\}", re.DOTALL)
_FIGURE = re.compile(r"!\[([^]]*)\]\(figure:(\w+)\)")
_DATASET = re.compile(r'study\.open\("([\w/]+)"\)')
#: Datasets that ``study.recommend`` opens for a problem of the study; the study itself is slow to import.
OF_RECOMMEND = ("work_precision", "accuracy", "neighbours")
#: Numbers of the manuscript, which a page has as ``n``.
NUMBERS = "numbers.json"


def pages() -> list[Path]:
    """The first page and those of the gallery."""
    return [FOLDER / "index.md", *sorted((FOLDER / "gallery").glob("*.md"))]


def reads_of_pages() -> list[str]:
    """The files of the results that all these pages need."""
    return list(dict.fromkeys(file for page in pages() for file in reads(page.read_text(encoding="utf-8"))))


def reads(text: str) -> list[str]:
    """The files of the results that a page needs: datasets that it opens, figures that it shows, and the numbers."""
    opened = [*_DATASET.findall(text), *(OF_RECOMMEND if 'study.recommend("' in text else ())]
    datasets = [f"{name}.nc" for name in opened]
    return list(dict.fromkeys([*datasets, *(f"figures/{name}.svg" for _, name in _FIGURE.findall(text)), NUMBERS]))


@contextlib.contextmanager
def _beside(results: Path) -> Iterator[None]:
    """Work where ``study.open`` finds the results."""
    if results.name != "results":
        raise SystemExit(f"the folder of the results must be named 'results', not '{results.name}'.")
    with contextlib.chdir(results.parent):
        yield


def names_of(text: str, results: Path) -> dict[str, Any]:
    """What the lines of code of a page define."""
    names: dict[str, Any] = {"listed": listed, "number": number, "percent": percent}
    with _beside(results):
        names["n"] = json.loads(Path(results.name, NUMBERS).read_text(encoding="utf-8"))
        for code in _CODE.findall(text):
            exec(code, names)
    return names


def filled(text: str, results: Path, images: str = "/figures") -> str:
    """A page with the values of its expressions and its figures, each with what makes it.

    Parameters
    ----------
    images
        Folder of the figures among the sources of the site.
    """
    names = names_of(text, results)

    def figure(found: re.Match) -> str:
        label, name = found.groups()
        return (
            f"```{{figure}} {images}/{name}.svg\n:alt: {label}\n:class: paper\n\n"
            f"{label}. `.venv/bin/snakemake results/figures/{name}.svg` makes it.\n```"
        )

    text = _LINES_FIRST.sub(r"\1\3\n## The lines of code\n\n\2", text)
    parts = re.split(r"(^```python\n.*?^```$)", text, flags=re.DOTALL | re.MULTILINE)
    written = [
        part if part.startswith("```python") else _EXPRESSION.sub(lambda one: str(eval(one[1], names)), part)
        for part in parts
    ]
    return _FIGURE.sub(figure, "".join(written))
