"""The ledger of claims as a table."""

import pandas as pd

from paper.claims.ledger import OURS
from paper.products import table


@table("Ledger of claims", claims="claims.csv")
def tabulate(claims: pd.DataFrame) -> pd.DataFrame:
    """One row per claim with its source. For a claim of the paper, the row also has the section and a quotation."""
    section = (", " + claims["section"]).where(~claims["section"].isin(list(OURS)), "")
    words = (" “" + claims["words"] + "”").where(claims["words"] != "", "")
    reason = ("; " + claims["reason"]).where(claims["reason"] != "", "")
    return pd.DataFrame(
        {
            "No.": claims["number"],
            "Whose": claims["whose"] + section,
            "Claim": claims["claim"] + words,
            "Decided by": claims["quantity"],
            "Printed": claims["printed"],
            "Ours": claims["ours"],
            "Verdict": claims["verdict"] + reason,
        }
    )
