"""The gallery: the grid of its questions with their figures, and the scripts of its pages."""

import re
from pathlib import Path

from docs.executed import CODE
from docs.plan import PAGES

_PICTURE = re.compile(r"```\{figure\} /(figures/\w+\.svg)\n:alt: (.*)\n")


def questions() -> list[Path]:
    """The pages of the gallery, in the order of its index."""
    folder = PAGES / "gallery"
    named = re.search(r"```\{toctree\}\n(?::.*\n)*\n(.*?)```", (folder / "index.md").read_text("utf-8"), re.DOTALL)
    return [folder / f"{name}.md" for name in (named[1].split() if named else [])]


def grid() -> str:
    """The grid as Markdown: for every page its figure, with the question below it."""
    cards = []
    for page in questions():
        text = page.read_text("utf-8")
        title, (figure, about) = text.partition("\n")[0].removeprefix("# "), _PICTURE.findall(text)[0]
        cards.append(
            f"```{{figure}} /{figure}\n:alt: {about}\n:class: paper\n:target: {page.stem}.html\n:loading: lazy\n\n"
            f"[{title}]({page.name})\n```"
        )
    return ":::{container} grid\n" + "\n\n".join(cards) + "\n:::\n"


def write_scripts(folder: Path) -> None:
    """Write the Python of every page to a file next to the page, and add a link to this file to the page."""
    for page in questions():
        text = page.read_text("utf-8")
        (folder / f"{page.stem}.py").write_text("\n".join(CODE.findall(text)), "utf-8")
        link = f"{{download}}`Download this script <{page.stem}.py>`; it runs next to the folder `results/`."
        (folder / page.name).write_text(f"{text}\n{link}\n", "utf-8")
