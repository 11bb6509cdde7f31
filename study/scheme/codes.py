"""Names of the schemes in other programs."""

from pathlib import Path
from typing import NamedTuple

from study.io import read


class NameInCode(NamedTuple):
    """Name of a scheme in another program, as written in an input file, and the source that documents it."""

    scheme: str
    code: str
    name: str
    note: str
    source: str


def names_in_codes() -> list[NameInCode]:
    """All confirmed names of schemes in other programs, from ``codes.csv``."""
    return [NameInCode(**row) for row in read(Path(__file__).with_suffix(".csv")).to_dict("records")]
