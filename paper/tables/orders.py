"""Observed order of every scheme in every measure of error."""

import pandas as pd
import xarray as xr

from paper.orders import MEASURES, observed_order
from paper.tables.writing import main


def tabulate(accuracy: xr.Dataset) -> pd.DataFrame:
    """One row a problem and scheme, a column a measure; a dash where no order can be fitted."""
    rows = []
    for problem in accuracy.problem.values:
        for scheme in accuracy.scheme.values:
            run = accuracy.sel(problem=problem, scheme=scheme)
            row = {"Problem": problem, "Scheme": run.scheme_title.item(), "Order": str(run.order.item())}
            for measure, title in MEASURES.items():
                order = observed_order(run[measure])
                row[title] = f"{order:.2f}" if order == order else "–"
            rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main(tabulate)
