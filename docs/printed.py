"""Limits of stability that textbooks print for a scheme."""

import csv
import math
from pathlib import Path

from docs.text import number

_FILE = Path(__file__).parent / "printed_limits.csv"


def rows() -> list[dict[str, str]]:
    """All rows: scheme, printed limit of ωΔt without damping, work and place in it."""
    with _FILE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def printed_limit(scheme: str) -> str:
    """What is printed, in a phrase; empty where nothing has been confirmed."""
    told = []
    for row in rows():
        if row["scheme"] == scheme:
            limit = float(row["limit"])
            said = "at any step size" if math.isinf(limit) else f"ωΔt ≤ {number(limit, 4)}"
            told.append(f"{said} in {row['work']}, {row['place']}")
    return "; ".join(told)
