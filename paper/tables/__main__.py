"""``python -m paper.tables RESULTS FOLDER`` writes every table as CSV and as LaTeX with the rules of booktabs."""

import sys
from pathlib import Path

from paper.products import discover, made, reader


def main(results: Path, folder: Path) -> None:
    """Write the tables of a folder of results, which are frames of ready texts."""
    read = reader(results)
    for product in (one for one in discover(["tables"]) if one.kind == "table"):
        frame = made(product, read)
        frame.to_csv(folder / f"{product.name}.csv", index=False)
        (folder / f"{product.name}.tex").write_text(frame.to_latex(index=False, escape=True))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
