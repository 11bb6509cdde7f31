"""Tables, facts and heads of pages in Markdown."""

from collections.abc import Iterable, Mapping


def table(head: Iterable[str], rows: Iterable[Iterable[str]], numbers_from: int = 1) -> str:
    """A table in Markdown, whose columns from ``numbers_from`` on hold numbers."""
    head = list(head)
    rule = ["---" if column < numbers_from else "--:" for column in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def narrowed(
    head: str, rows: str, labels: tuple[str, str], placeholder: str, choices: str = "", kind: str = "plain"
) -> str:
    """A table with its own scroll bar, below a form that filters its rows by words; see ``static/table.js``.

    Parameters
    ----------
    head, rows
        Rows of the head and of the body of the table as HTML.
    what
        Noun of the rows, as in "Show schemes with", and label of the table for screen readers.
    placeholder
        Examples of words.
    choices
        Further elements of the form as HTML.
    kind
        Class of the table in CSS.
    """
    shown, label = labels
    return (
        f'<form class="narrow" hidden><label>Show {shown} with <input type="search" name="words" '
        f'placeholder="{placeholder}"></label> {choices}</form>\n'
        f'<div class="wide" tabindex="0" role="region" aria-label="{label}">\n<table class="sortable {kind}">\n'
        f"<thead>{head}</thead>\n<tbody>\n{rows}\n</tbody>\n</table>\n</div>\n"
    )


def definitions(facts: Mapping[str, str]) -> str:
    """A list of definitions as HTML: each fact with its name. The facts are HTML already."""
    inside = "".join(f"<dt>{name}</dt><dd>{fact}</dd>\n" for name, fact in facts.items())
    return f'<dl class="facts">\n{inside}</dl>\n'


def described(description: str, body: str, hide_toc: bool = False) -> str:
    """A page in Markdown with a description for search engines, and optionally without a list of its headings."""
    sentence = description.replace('"', "'")
    hidden = "hide-toc: true\n" if hide_toc else ""
    return f'---\n{hidden}myst:\n  html_meta:\n    description: "{sentence}"\n---\n\n{body}'


def index_entries(names: Iterable[str]) -> str:
    """Entries of the index with the names of a page; a search for a name then lists the page first."""
    entries = ", ".join(f"! {name.replace('_', ' ')}" for name in names)
    return f"```{{index}} {entries}\n```"
