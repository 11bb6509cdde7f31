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


class StepInDeck(NamedTuple):
    """Line of the input file of a program that holds the step size, the line before it, and the source of both.

    The source is empty if the line is not confirmed.
    """

    code: str
    after: str
    line: str
    note: str
    source: str


def steps_in_decks() -> list[StepInDeck]:
    """Where the step size stands in the input files of common programs, from ``decks.csv``."""
    rows = read(Path(__file__).with_name("decks.csv")).fillna("").to_dict("records")
    return [StepInDeck(**row) for row in rows]


def names_in_codes() -> list[NameInCode]:
    """All confirmed names of schemes in other programs, from ``codes.csv``."""
    return [NameInCode(**row) for row in read(Path(__file__).with_suffix(".csv")).to_dict("records")]
