"""What moves the medians of collapse intensity, drift and residual drift of a yielding mass with P-Δ."""

import pandas as pd
import xarray as xr

from paper.measures.what_moves import CHOSEN, QUANTITIES, choice_spread, median_changes
from paper.products import table
from paper.tables.decision import sentence
from study.words import span


@table("What moves the median over records")
def tabulate(what_moves: xr.Dataset) -> pd.DataFrame:
    """One row per variant and per choice of records: the range over the periods of the change in percent.

    A choice of records changes a median by half of its 95 % interval.
    """
    variants = [name for name in what_moves.variant.values if name != "reference"]
    changes = {name: 100 * median_changes(what_moves[name]).change for name in QUANTITIES}
    rows = [
        {"Change": sentence(what_moves.variant_title.sel(variant=variant).item())}
        | {
            sentence(title): span(changes[name].sel(variant=variant), "+.1f").replace("-", "−")
            for name, title in QUANTITIES.items()
        }
        for variant in variants
    ]
    for count in CHOSEN:
        spreads = {
            sentence(title): "±" + span(100 * choice_spread(what_moves[name], count), ".0f").replace("to ", "to ±")
            for name, title in QUANTITIES.items()
        }
        rows.append({"Change": f"Choice of {count} records"} | spreads)
    return pd.DataFrame(rows)
