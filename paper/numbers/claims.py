"""Numbers of the text: counts of claims by verdict, for each part of the ledger."""

import pandas as pd

from paper.claims.ledger import OURS, PRACTICE, STUDY, Verdict
from paper.products import numbers

#: Claims of 1996 on numerical damping, on the worst scheme and on chaos, which the article discusses.
JUDGED = [
    "The grave errors of Newmark (γ = 0.6), Houbolt and Wilson come from strong numerical damping.",
    "Newmark with β = 0.3025 and γ = 0.6 is the worst of the seven.",
    "At this step average acceleration becomes chaotic.",
]


@numbers(claims="claims.csv")
def claim_numbers(claims: pd.DataFrame) -> dict:
    """Counts of claims by verdict, for the paper, for each additional section, and of schemes by who makes them."""
    ours = claims["section"].isin(list(OURS))
    parts = {"claims": claims[~ours]} | {prefix: claims[claims["section"] == name] for name, prefix in OURS.items()}
    schemes = claims[claims["section"] == "schemes"]
    parts["author_claims"] = schemes[~schemes["whose"].isin([PRACTICE, STUDY])]
    parts["practice_claims"] = schemes[schemes["whose"] == PRACTICE]
    counts: dict = {}
    for prefix, part in parts.items():
        count = part["verdict"].value_counts()
        counts |= {
            prefix: len(part),
            f"{prefix}_reproduced": int(count.get(Verdict.REPRODUCED, 0)),
            f"{prefix}_qualified": int(count.get(Verdict.QUALIFIED, 0)),
            f"{prefix}_not_reproduced": int(count.get(Verdict.NOT_REPRODUCED, 0)),
            f"{prefix}_undecided": int(count.get(Verdict.UNDECIDED, 0)),
        }
    verdicts = claims.set_index("claim")["verdict"]
    return counts | {"verdicts_confirmed": bool((verdicts[JUDGED] == Verdict.REPRODUCED).all())}
