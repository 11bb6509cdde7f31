"""Facts on schemes from other sources: names in other codes, and limits of stability in textbooks."""

import math
from pathlib import Path

from docs.text import table
from study.io import read
from study.scheme.codes import names_in_codes as all_names
from study.scheme.codes import steps_in_decks
from study.words import number


def decks() -> str:
    """A table of the lines that hold the step size in the input files of common codes."""
    rows = [
        [
            row.code,
            f"`{row.after}`" if row.after else "–",
            f"`{row.line}`" if row.line else "–",
            row.note,
            f"[documentation]({row.source})" if row.source else "–",
        ]
        for row in steps_in_decks()
    ]
    return table(["code", "below", "line with the step", "remark", "source"], rows, numbers_from=5)


def limits() -> list[dict[str, str]]:
    """Rows of ``printed_limits.csv``: the limits of stability that textbooks print."""
    return read(Path(__file__).with_name("printed_limits.csv")).to_dict("records")


def names_in_codes(scheme: str) -> str:
    """A table of the names of one scheme in other codes, or a sentence if none has been confirmed."""
    rows = [
        [entry.code, f"`{entry.name}`", entry.note, f"[documentation]({entry.source})"]
        for entry in all_names()
        if entry.scheme == scheme
    ]
    if not rows:
        return "No name of this scheme in another code has been confirmed."
    return table(["code", "name and parameters", "remark", "source"], rows, numbers_from=4)


def printed_limit(scheme: str) -> str:
    """Stability limits of a scheme that textbooks print, in a phrase; empty if no limit has been confirmed."""
    entries = [(float(row["limit"]), row) for row in limits() if row["scheme"] == scheme]
    return "; ".join(
        f"{'at any step size' if math.isinf(limit) else f'ωΔt ≤ {number(limit, 4)}'} in {row['work']}, {row['place']}"
        for limit, row in entries
    )
