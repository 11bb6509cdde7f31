"""The ledger of claims as a table, with the schemes under their titles."""

import sys
from pathlib import Path

import pandas as pd
import xarray as xr

from paper.data import load
from paper.tables.writing import write


def tabulate(claims: pd.DataFrame, energy_error: xr.Dataset) -> pd.DataFrame:
    """One row a claim."""
    titles = zip(energy_error.scheme.values, energy_error.scheme_title.values, strict=True)
    plain = claims.replace({name: title for name, title in titles}, regex=True)
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


if __name__ == "__main__":
    claims = pd.read_csv(sys.argv[2], dtype=str, keep_default_na=False)
    write(tabulate(claims, load(sys.argv[3])), Path(sys.argv[1]))
