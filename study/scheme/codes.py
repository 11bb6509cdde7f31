"""Names of the schemes in other codes."""

from pathlib import Path
from typing import NamedTuple

from study.io import read


class NameInCode(NamedTuple):
    """The name of a scheme in a code, as written in an input file, and its documentation."""

    scheme: str
    code: str
    name: str
    note: str
    source: str


def names_in_codes() -> list[NameInCode]:
    """All names that were confirmed, by scheme."""
    return [NameInCode(**row) for row in read(Path(__file__).with_suffix(".csv")).to_dict("records")]
