"""All tables on one page."""

from typing import Any

import pandas as pd

from paper.pages import STYLE
from paper.products import discover, page
from study.words import document, text_of

#: The tables by name; the ledger has a separate page.
_TABLES = {
    product.name: product for product in discover(["tables"]) if product.kind == "table" and product.name != "claims"
}
_FILES: dict[str, Any] = {name: f"tables/{name}.csv" for name in _TABLES}


def _title(name: str) -> str:
    return text_of(_TABLES[name].title)


def _section(name: str, frame: pd.DataFrame) -> str:
    rows = frame.to_html(index=False, border=0, justify="left")
    about = (_TABLES[name].function.__doc__ or "").strip().splitlines()[0]
    # a table that is wider than the screen scrolls separately
    return (
        f'<h2 id="{name}">{_title(name)}</h2><p class="note">{text_of(about)}</p>'
        f'<div class="scroll" tabindex="0" role="region" aria-label="table: {_title(name)}">{rows}</div>\n'
    )


@page("All tables of the study.", **_FILES)
def tables(**frames: pd.DataFrame) -> str:
    """The page: links to the tables, then all tables."""
    links = "".join(f'<li><a href="#{name}">{_title(name)}</a></li>' for name in frames)
    return document("Tables", [f"<nav><ul>{links}</ul></nav>", *(_section(*frame) for frame in frames.items())], STYLE)
