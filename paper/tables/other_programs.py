"""Verdicts of the conformance kit on the integrators of other programs."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pandas as pd

from paper.products import table

VERDICTS = Path(__file__).parents[2] / "conformance" / "verdicts"
#: Files of the verdicts on other programs; the verdicts on this study and on the examples of the kit are left out.
PROGRAMS = tuple(
    sorted({file.name for file in VERDICTS.glob("*.json")} - {"study.json", "c_example.json", "numpy_example.json"})
)


def verdicts(file: str) -> dict[str, Any]:
    """Name, version and cases of a program, each case with its verdict, from a file in the folder ``VERDICTS``."""
    return json.loads((VERDICTS / file).read_text(encoding="utf-8"))


def _likely(code: dict[str, Any]) -> str:
    """The most frequent cause of an unexpected result, with its number of cases; empty if all results agree."""
    unexpected = [case for case in code["cases"] if case["verdict"] in ("differs", "fail")]
    causes = Counter(case.get("cause") or case["finding"] for case in unexpected)
    return "".join(f"{cause} ({cases})" for cause, cases in causes.most_common(1))


@table("Conformance of other programs")
def tabulate() -> pd.DataFrame:
    """One row per program or part of one: its cases by verdict, and the most frequent cause of an unexpected result."""
    rows = []
    for code in map(verdicts, PROGRAMS):
        counts = code["counts"]
        rows.append(
            {
                "Program": f"{code['tool']} ({code['version']})",
                "Cases": counts["pass"] + counts["differs"] + counts["fail"],
                "As named": counts["pass"],
                "Alternative": counts["differs"],
                "Fail": counts["fail"],
                "Most frequent cause (cases)": _likely(code),
            }
        )
    return pd.DataFrame(rows)
