"""The table of the ledger."""

import pandas as pd

from paper.tables import claims

_ROW = {"number": "1", "claim": "It grows.", "quantity": "size", "printed": "", "ours": "2", "verdict": "reproduced"}


def test_the_table_states_whose_a_claim_is():
    ledger = pd.DataFrame(
        [
            _ROW | {"section": "3.1", "whose": "Xie", "words": "is growing", "reason": "but slowly"},
            _ROW | {"section": "stability", "whose": "practice", "words": "", "reason": ""},
        ]
    )
    first, second = claims.tabulate(ledger).to_dict("records")
    assert first["Whose"] == "Xie, 3.1" and second["Whose"] == "practice"
    assert first["Claim"] == "It grows. “is growing”" and second["Claim"] == "It grows."
    assert first["Verdict"] == "reproduced; but slowly" and second["Verdict"] == "reproduced"
