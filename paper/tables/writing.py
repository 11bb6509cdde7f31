"""How the tables are written."""

import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd

from paper.data import load


def write(table: pd.DataFrame, output: Path) -> None:
    """Write a table of ready texts as CSV and as LaTeX with the rules of booktabs."""
    table.to_csv(output.with_suffix(".csv"), index=False)
    output.with_suffix(".tex").write_text(table.to_latex(index=False, escape=True))


def main(tabulate: Callable[..., pd.DataFrame]) -> None:
    """Tabulate the datasets named on the command line."""
    output, *paths = map(Path, sys.argv[1:])
    write(tabulate(*map(load, paths)), output)
