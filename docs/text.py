"""Tables, facts and heads of pages in Markdown."""

from collections.abc import Iterable, Mapping


def table(head: Iterable[str], rows: Iterable[Iterable[str]], numbers_from: int = 1) -> str:
    """A table in Markdown, whose columns from ``numbers_from`` on hold numbers."""
    head = list(head)
    rule = ["---" if column < numbers_from else "--:" for column in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def definitions(facts: Mapping[str, str]) -> str:
    """A list of facts with their names; the facts are HTML."""
    inside = "".join(f"<dt>{name}</dt><dd>{fact}</dd>\n" for name, fact in facts.items())
    return f'<dl class="facts">\n{inside}</dl>\n'


def described(description: str, body: str, hide_toc: bool = False) -> str:
    """A page in Markdown with the sentence that search engines show, and without a list of its headings if asked."""
    sentence = description.replace('"', "'")
    hidden = "hide-toc: true\n" if hide_toc else ""
    return f'---\n{hidden}myst:\n  html_meta:\n    description: "{sentence}"\n---\n\n{body}'


def found_by(names: Iterable[str]) -> str:
    """Entries of the index, which the search of the site puts first."""
    entries = ", ".join(f"! {name.replace('_', ' ')}" for name in names)
    return f"```{{index}} {entries}\n```"
