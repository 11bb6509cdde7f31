"""What other codes call the schemes."""

import csv
from pathlib import Path
from typing import NamedTuple


class NameInCode(NamedTuple):
    """The name of a scheme in a code, as it stands in an input file, and where that is documented."""

    scheme: str
    code: str
    name: str
    note: str
    source: str


def names_in_codes() -> list[NameInCode]:
    """All names that were confirmed, by scheme."""
    with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        return [NameInCode(**row) for row in csv.DictReader(file)]
