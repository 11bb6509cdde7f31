"""The page of the conformance kit: how to run it, and its results for codes."""

import json
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.text import described, table

RESULTS = Path(__file__).parent.parent / "conformance" / "verdicts"

#: Causes shown for failed cases of the kinds order and bound. They replace the causes in the files of verdicts, which
#: contain numbers that differ between cases.
_OF_KIND = {"ORDER": "the order is not that of the scheme", "BOUND": "the energy grows"}

#: Verdicts with a column for their number of cases. The remaining verdict is ``skip``.
_SHOWN = ("pass", "differs", "fail")

#: Maximum number of cases that a row names as examples.
SHOWN = 4


def found() -> list[dict[str, Any]]:
    """Verdicts of all codes; the code with the most passes is first."""
    results = [json.loads(file.read_text(encoding="utf-8")) for file in RESULTS.glob("*.json")]
    return sorted(results, key=lambda one: (-one["counts"]["pass"], one["tool"]))


def _named(code: Mapping[str, Any]) -> str:
    return f"{code['tool']} {code['version']}".strip()


def _overview(codes: Sequence[Mapping[str, Any]]) -> str:
    """A table with a row for every code: by level, the number of passed cases over the number of supported cases."""
    rows = []
    for code in codes:
        ran, passed = Counter[str](), Counter[str]()
        for case in code["cases"]:
            ran[case["name"][0]] += case["verdict"] != "skip"
            passed[case["name"][0]] += case["verdict"] == "pass"
        levels = [f"{passed[level]}/{ran[level]}" if ran[level] else "–" for level in "ABCDEFG"]
        counts = [str(code["counts"][verdict]) for verdict in _SHOWN]
        rows.append([_named(code), code["kit"], *levels, *counts])
    return table(["code", "cases", *"ABCDEFG", *_SHOWN], rows)


def _causes(code: Mapping[str, Any]) -> str:
    """Table of alternatives, then of likely causes, the most frequent first; empty if no case differs or fails."""
    cases = defaultdict(list)
    for case in code["cases"]:
        if case["verdict"] in ("differs", "fail"):
            cause = _OF_KIND.get(case["name"].split("-")[1], case["cause"])
            cases[case["verdict"], cause].append(case["name"])
    rows = [
        [verdict, cause, str(len(names)), ", ".join(names[:SHOWN]) + (" ..." if len(names) > SHOWN else "")]
        for (verdict, cause), names in sorted(cases.items(), key=lambda item: (item[0][0], -len(item[1])))
    ]
    if not rows:
        return ""
    head = ["verdict", "alternative or likely cause", "cases", "examples"]
    return "\n\n".join([f"### {_named(code)}", code["note"], table(head, rows, 4)])


def conformance_page() -> str:
    """The page in Markdown: the guide of the kit, and the results for codes."""
    codes = found()
    parts = [
        "```{include} /included/conformance.md\n```",
        "## Results for codes",
        "Each cell gives the passed cases over the supported cases of a level. Unsupported cases are skipped. The name "
        "of a code ends with its version.",
        _overview(codes),
        *filter(None, map(_causes, codes)),
    ]
    sentence = "A kit of cases that checks whether the time integrator of a code implements the scheme of its name."
    return described(sentence, "\n\n".join(parts) + "\n")
