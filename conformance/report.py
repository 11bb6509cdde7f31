"""Verdicts as a table in text, as a dictionary for a JSON file, as an HTML page and as a badge."""

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import date
from html import escape
from typing import Any

from conformance import VERSION
from conformance.judge import Verdict

VERDICTS = ("pass", "differs", "fail", "skip")

#: Order of the rows of a page, by verdict.
_ROWS = ("fail", "differs", "pass", "skip")

_HEAD = ("case", "scheme and problem", "verdict", "digits", "cause", "agrees")

_STYLE = """body {font: 16px/1.4 sans-serif; margin: 2em auto; max-width: 70em; padding: 0 1em}
table {border-collapse: collapse} th, td {border-bottom: 1px solid #ccc; padding: .2em .7em; text-align: left}
.fail {background: #fdd} .differs {background: #ffd} .skip {color: #777}"""


def summary(verdicts: Sequence[Verdict], tool: str, version: str, note: str) -> dict[str, Any]:
    """Counts of the verdicts on a version of a tool, and all verdicts, as the dictionary for a JSON file."""
    counts = Counter(entry.verdict for entry in verdicts)
    return {
        "kit": VERSION,
        "tool": tool,
        "version": version,
        "date": date.today().isoformat(),
        "note": note,
        "counts": {verdict: counts[verdict] for verdict in VERDICTS},
        "cases": [
            {name: value for name, value in entry._asdict().items() if value not in (None, "")} for entry in verdicts
        ],
    }


def table(verdicts: Sequence[Verdict]) -> str:
    """Verdicts other than pass and skip, one per line, and the counts of all verdicts."""
    lines = [
        (
            f"{entry.name:16} {entry.verdict:8} {'' if entry.digits is None else f'{entry.digits:4.1f}':5} "
            f"{entry.sentence}"
        ).rstrip()
        for entry in verdicts
        if entry.verdict in ("differs", "fail")
    ]
    counts = Counter(entry.verdict for entry in verdicts)
    return "\n".join([*lines, ", ".join(f"{verdict} {counts[verdict]}" for verdict in VERDICTS)])


def badge(result: Mapping[str, Any]) -> str:
    """SVG badge with the number of passed cases of all cases, from the ``summary`` of a tool; red if a case fails."""
    text = f"{result['counts']['pass']} of {len(result['cases'])}"
    colour = "#c33" if result["counts"]["fail"] else "#282"
    return f"""<svg xmlns="http://www.w3.org/2000/svg" width="170" height="20" role="img">
<title>conformance: {text}</title>
<rect width="90" height="20" fill="#555"/><rect x="90" width="80" height="20" fill="{colour}"/>
<g fill="#fff" text-anchor="middle" font-family="Verdana,sans-serif" font-size="11">
<text x="45" y="14">conformance</text><text x="130" y="14">{text}</text></g></svg>"""


def page(result: Mapping[str, Any], titles: Mapping[str, str]) -> str:
    """HTML page of the verdicts on a tool, from its ``summary`` and the title of each case."""
    tool = escape(f"{result['tool']} {result['version']}".strip())
    counts = ", ".join(f"{verdict} {number}" for verdict, number in result["counts"].items())
    rows = [
        f'<tr class="{entry["verdict"]}"><td>{escape(entry["name"])}</td><td>{escape(titles[entry["name"]])}</td>'
        f"<td>{entry['verdict']}</td><td>{entry.get('digits', '')}</td><td>{escape(Verdict(**entry).sentence)}</td>"
        f"<td>{entry.get('where', '')}</td></tr>"
        for entry in sorted(result["cases"], key=lambda entry: _ROWS.index(entry["verdict"]))
    ]
    return "\n".join(
        [
            f'<!DOCTYPE html>\n<html lang="en"><meta charset="utf-8"><title>Conformance of {tool}</title>',
            f"<style>{_STYLE}</style>\n<h1>Conformance of {tool}</h1>",
            f"<p>Cases {result['kit']}, {result['date']}: {counts}. "
            "Digits are those of the worst value, relative to the largest.</p>",
            f"<p>{escape(result['note'])}</p>",
            f"<table><tr>{''.join(f'<th>{name}</th>' for name in _HEAD)}</tr>",
            *rows,
            "</table></html>",
        ]
    )
