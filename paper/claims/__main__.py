"""``python -m paper.claims RESULTS OUTPUT`` checks every claim against the datasets that it reads."""

import sys
from pathlib import Path

import pandas as pd

from paper.claims.ledger import CLAIMS
from paper.products import discover, made, reader
from paper.writing import write


def main(results: Path, output: Path) -> None:
    """Write the ledger, a line a claim, in the order of the paper's sections."""
    discover(["claims"])
    read = reader(results)
    rows = []
    for number, claim in enumerate(sorted(CLAIMS, key=lambda one: one.section), start=1):
        finding = made(claim.product, read)
        rows.append(
            {
                "number": number,
                "section": claim.section,
                "claim": claim.statement,
                "quantity": claim.quantity,
                "printed": claim.printed,
                "ours": finding.ours,
                "verdict": str(finding.verdict),
                "reason": finding.qualification,
            }
        )
    write(output, pd.DataFrame(rows).to_csv(index=False))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
