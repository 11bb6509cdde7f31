"""A page of text and tables that loads nothing."""

import html
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

_STYLE = Path(__file__).with_name("page.css")


def text_of(value: object) -> str:
    """A text as HTML."""
    return html.escape(str(value))


def table_of(frame: pd.DataFrame) -> str:
    """A frame of texts as a table, which scrolls by itself where the screen is narrower."""
    rows = frame.to_html(index=False, border=0, justify="left")
    return f'<div class="scroll" tabindex="0" role="region" aria-label="table">{rows}</div>'


def document(title: str, parts: Iterable[str]) -> str:
    """A page of HTML."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<title>{text_of(title)}</title><style>\n{_STYLE.read_text(encoding='utf-8')}</style></head>\n"
        f"<body><h1>{text_of(title)}</h1>\n{''.join(parts)}</body></html>\n"
    )
