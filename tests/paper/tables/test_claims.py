"""The ledger as a table."""

import pandas as pd
import xarray as xr

from paper.tables.claims import tabulate


def _titled(**titles):
    return xr.Dataset(coords={"scheme": list(titles), "scheme_title": ("scheme", list(titles.values()))})


def test_every_scheme_has_its_title():
    row = {
        "number": "1",
        "section": "structures",
        "claim": "c",
        "quantity": "q",
        "printed": "",
        "verdict": "reproduced",
    }
    ours = "houbolt: -1.0; bathe: 29.9; bathe_rho: 2e-16"
    claims = pd.DataFrame([row | {"ours": ours, "reason": "so is bathe"}])
    titled = [_titled(houbolt="Houbolt"), _titled(houbolt="Houbolt", bathe="Bathe", bathe_rho="ρ∞-Bathe")]
    (shown,) = tabulate(claims, titled).to_dict("records")
    assert shown["Ours"] == "Houbolt: −1.0; Bathe: 29.9; ρ∞-Bathe: 2e−16"
    assert shown["Verdict"] == "reproduced; so is Bathe"
