"""``python -m paper.tables RESULTS FOLDER`` writes every table as CSV and as LaTeX with the rules of booktabs."""

import sys
from pathlib import Path

from paper.products import content_of, discover, reader
from paper.tables.tex import tex
from study.io import one_sentence, write
from study.words import printed


@one_sentence()
def main(results: Path, folder: Path) -> None:
    """Write all tables from a folder of results."""
    read = reader(results)
    for product in (product for product in discover(["tables"]) if product.kind == "table"):
        frame = content_of(product, read).map(lambda cell: printed(str(cell))).rename(columns=printed)
        write(frame.to_csv(index=False), folder / f"{product.name}.csv")
        write(tex(product, frame), folder / f"{product.name}.tex")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
