"""Numbers and tables for pages."""

import math
from collections.abc import Iterable, Mapping

#: Digits and a minus as exponents.
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
#: Below this a fraction is zero to round-off.
_ZERO = 1e-6


def number(value: float, digits: int = 3) -> str:
    """A number with some digits; ∞, and a dash for none."""
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞"
    if value and not 1e-3 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{max(digits - 2, 0)}e}".split("e")
        return f"{mantissa.replace('-', '−')}·10{str(int(exponent)).translate(RAISED)}"
    return f"{float(format(value, f'.{digits}g')):g}".replace("-", "−")


def percent(fraction: float, digits: int = 2) -> str:
    """A fraction in percent, zero if it is zero to round-off."""
    if math.isnan(fraction):
        return "–"
    return f"{number(100 * fraction, digits)} %" if abs(fraction) > _ZERO else "0 %"


def table(head: Iterable[str], rows: Iterable[Iterable[str]], numbers_from: int = 1) -> str:
    """A table in Markdown, whose columns from ``numbers_from`` on hold numbers."""
    head = list(head)
    rule = ["---" if column < numbers_from else "--:" for column in range(len(head))]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *rows])


def definitions(facts: Mapping[str, str]) -> str:
    """A list of facts with their names; the facts are HTML."""
    inside = "".join(f"<dt>{name}</dt><dd>{fact}</dd>\n" for name, fact in facts.items())
    return f'<dl class="facts">\n{inside}</dl>\n'


def listed(words: Iterable[str]) -> str:
    """Words as they stand in a sentence: a, b and c."""
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last


def described(description: str, body: str, hide_toc: bool = False) -> str:
    """A page in Markdown with the sentence that search engines show, and without a list of its headings if asked."""
    sentence = description.replace('"', "'")
    hidden = "hide-toc: true\n" if hide_toc else ""
    return f'---\n{hidden}myst:\n  html_meta:\n    description: "{sentence}"\n---\n\n{body}'
