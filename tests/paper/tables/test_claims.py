"""The ledger as a table."""

import pandas as pd

from paper.tables.claims import tabulate

_ROW = {"number": "1", "claim": "It grows.", "quantity": "size", "printed": "", "ours": "2", "verdict": "reproduced"}


def test_the_table_tells_whose_a_claim_is():
    claims = pd.DataFrame(
        [
            _ROW | {"section": "3.1", "whose": "Xie", "words": "is growing", "reason": "but slowly"},
            _ROW | {"section": "stability", "whose": "practice", "words": "", "reason": ""},
        ]
    )
    first, second = tabulate(claims).to_dict("records")
    assert first["Whose"] == "Xie, 3.1" and second["Whose"] == "practice"
    assert first["Claim"] == "It grows. “is growing”" and second["Claim"] == "It grows."
    assert first["Verdict"] == "reproduced; but slowly" and second["Verdict"] == "reproduced"
