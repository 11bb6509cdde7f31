"""``python -m paper.tables RESULTS FOLDER`` writes every table as CSV and as LaTeX with the rules of booktabs."""

import sys
from pathlib import Path

from paper.printing import printed
from paper.products import discover, made, reader
from paper.writing import write


def main(results: Path, folder: Path) -> None:
    """Write the tables of a folder of results, which are frames of ready texts."""
    read = reader(results)
    for product in (one for one in discover(["tables"]) if one.kind == "table"):
        frame = made(product, read).map(lambda cell: printed(str(cell))).rename(columns=printed)
        write(folder / f"{product.name}.csv", frame.to_csv(index=False))
        write(folder / f"{product.name}.tex", frame.to_latex(index=False, escape=True))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
