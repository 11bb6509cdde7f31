"""What the schemes are called in other codes."""

import csv
from pathlib import Path

_FILE = Path(__file__).parent / "names_in_codes.csv"


def rows() -> list[dict[str, str]]:
    """All rows: scheme, code, name, parameters, note and source."""
    with _FILE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def names_in_codes(name: str) -> str:
    """A table of the names of one scheme, or a sentence."""
    found = [row for row in rows() if row["scheme"] == name]
    if not found:
        return "No name of this scheme in OpenSees, Abaqus, LS-DYNA, Code_Aster or SciML has been confirmed."
    lines = ["| code | name and parameters | remark | source |", "|---|---|---|---|"]
    lines += [
        f"| {row['code']} | `{row['name']}` | {row['note']} | [documentation]({row['source']}) |" for row in found
    ]
    return "\n".join(lines)
