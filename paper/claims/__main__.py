"""``python -m paper.claims RESULTS OUTPUT`` checks every claim against the datasets that it reads."""

import sys
from pathlib import Path

import pandas as pd

from paper.claims.ledger import CLAIMS, XIE
from paper.products import content_of, discover, reader
from study.io import one_sentence, write


@one_sentence()
def main(results: Path, output: Path) -> None:
    """Write the ledger as CSV: the paper's claims by section, numbered 1, 2, ..., then the other claims, A1, A2, ..."""
    discover(["claims"])
    read = reader(results)
    rows = []
    printed = sum(claim.whose == XIE for claim in CLAIMS)
    for number, claim in enumerate(sorted(CLAIMS, key=lambda claim: claim.section), start=1):
        finding = content_of(claim.product, read)
        rows.append(
            {
                "number": f"{number}" if number <= printed else f"A{number - printed}",
                "section": claim.section,
                "whose": claim.whose,
                "claim": claim.statement,
                "words": claim.words,
                "quantity": claim.quantity,
                "printed": claim.printed,
                "ours": finding.ours,
                "verdict": str(finding.verdict),
                "reason": finding.qualification,
            }
        )
    write(pd.DataFrame(rows).to_csv(index=False), output)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
