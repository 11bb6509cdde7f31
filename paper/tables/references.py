"""The periods, and how far the routes to the reference differ."""

import pandas as pd
import xarray as xr

from paper.tables.writing import main


def tabulate(*references: xr.Dataset) -> pd.DataFrame:
    """One row a problem; differences relative to the size of the quantity."""
    rows = []
    for reference in references:
        row = {"Problem": reference.problem, "Period": reference.period_30_digits}
        for route in ("cvode", "diffrax"):
            title = {"cvode": "CVODE", "diffrax": "diffrax"}[route]
            difference = reference.period_difference.sel(route="closed_form", other_route=route).item()
            row[f"Period, {title}"] = f"{difference:.0e}"
        row["Trajectory, CVODE to diffrax"] = f"{reference.u_difference.sel(route='cvode', other_route='diffrax'):.0e}"
        closed = reference.u_difference.sel(route="closed_form", other_route="diffrax").item()
        row["Trajectory, closed form to diffrax"] = f"{closed:.0e}" if closed == closed else "none known"
        rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main(tabulate)
