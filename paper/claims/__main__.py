"""``python -m paper.claims OUTPUT RESULTS NAME...`` checks every claim against the named datasets."""

import sys
from pathlib import Path

import pandas as pd

from paper.claims import comparisons, conclusions, discussion, introduction, stability, structures  # noqa: F401  (they enter theirs)
from paper.claims.ledger import CLAIMS
from paper.data import load, of_the_paper
from paper.published import printed_energy_errors


def main(output: Path, results: Path, names: list[str]) -> None:
    """Write the ledger, a line a claim, in the order of the paper."""
    data = {name: load(results / f"{name}.nc") for name in names}
    # the paper speaks of its own schemes; on structures they stand beside those of today
    own = set(printed_energy_errors().scheme.values)
    data |= {
        name: of_the_paper(dataset)
        for name, dataset in data.items()
        if "scheme" in dataset.dims and own < set(dataset.scheme.values) and name != "structures"
    }
    rows = []
    for number, claim in enumerate(sorted(CLAIMS, key=lambda claim: claim.section), start=1):
        finding = claim.check(data)
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
    pd.DataFrame(rows).to_csv(output, index=False)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:])
