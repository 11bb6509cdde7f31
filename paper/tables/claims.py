"""The ledger of claims as a table, with the titles of the schemes in place of their names."""

import pandas as pd
import xarray as xr

from paper.products import table


@table(
    claims="claims.csv",
    titled=["energy_error", "structures", "structure_history/stiff_soft", "stability/roots", "kinks", "spectrum"],
)
def tabulate(claims: pd.DataFrame, titled: list[xr.Dataset]) -> pd.DataFrame:
    """One row per claim; ``titled`` are the datasets whose schemes the ledger lists."""
    titles = {
        rf"\b{name}\b": title
        for dataset in titled
        for name, title in zip(dataset.scheme.values, dataset.scheme_title.values, strict=True)
    }
    plain = claims.replace(titles, regex=True)
    plain["ours"] = plain["ours"].str.replace(r"(?<![\w-])-(?=\d)|(?<=\de)-(?=\d)", "−", regex=True)
    reason = ("; " + plain["reason"]).where(plain["reason"] != "", "")
    return pd.DataFrame(
        {
            "No.": plain["number"],
            "Section": plain["section"],
            "Claim": plain["claim"],
            "Decided by": plain["quantity"],
            "Printed": plain["printed"],
            "Ours": plain["ours"],
            "Verdict": plain["verdict"] + reason,
        }
    )
