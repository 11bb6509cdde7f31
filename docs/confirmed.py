"""Facts on schemes that were looked up elsewhere: names in other codes, and limits of stability in textbooks."""

import csv
import math
from pathlib import Path

from docs.text import table
from study.words import number

#: The files, whose columns their first lines name.
NAMES, LIMITS = "names_in_codes", "printed_limits"


def rows(name: str) -> list[dict[str, str]]:
    """All rows of a file."""
    with Path(__file__).with_name(f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def names_in_codes(scheme: str) -> str:
    """A table of the names of one scheme, or a sentence."""
    found = [
        [row["code"], f"`{row['name']}`", row["note"], f"[documentation]({row['source']})"]
        for row in rows(NAMES)
        if row["scheme"] == scheme
    ]
    if not found:
        return "No name of this scheme in OpenSees, Abaqus, LS-DYNA, Code_Aster or SciML has been confirmed."
    return table(["code", "name and parameters", "remark", "source"], found, numbers_from=4)


def printed_limit(scheme: str) -> str:
    """Limits that textbooks print, in a phrase; empty where none has been confirmed."""
    found = [(float(row["limit"]), row) for row in rows(LIMITS) if row["scheme"] == scheme]
    return "; ".join(
        f"{'at any step size' if math.isinf(limit) else f'ωΔt ≤ {number(limit, 4)}'} in {row['work']}, {row['place']}"
        for limit, row in found
    )
