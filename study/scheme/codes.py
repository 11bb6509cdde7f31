"""Names of the schemes in other codes."""

import csv
from pathlib import Path
from typing import NamedTuple


class NameInCode(NamedTuple):
    """The name of a scheme in a code, as written in an input file, and its documentation."""

    scheme: str
    code: str
    name: str
    note: str
    source: str


def names_in_codes() -> list[NameInCode]:
    """All names that were confirmed, by scheme."""
    with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        return [NameInCode(**row) for row in csv.DictReader(file)]
