"""The periods with their uncertainties, and the smallest errors of the solvers."""

from decimal import Decimal

import pandas as pd
import xarray as xr

from paper.products import table

_TITLES = {
    "cvode_adams": "Adams",
    "cvode_bdf": "BDF",
    "dopri8": "Dopri8",
    "tsit5": "Tsit5",
    "kvaerno5": "Kvaerno5",
    "heyoka": "heyoka",
}
#: Number of decimals of the periods in the table; the datasets hold thirty digits.
DIGITS = 20


@table(
    "Exact periods and errors of solvers",
    agreement="reference_agreement",
    references=["reference/hardening", "reference/softening", "reference/softening_large", "reference/double_well"],
    requires={"references.problems": ["hardening", "softening", "softening_large", "double_well"]},
)
def tabulate(agreement: xr.Dataset, references: list[xr.Dataset]) -> pd.DataFrame:
    """One row per problem: period, uncertainties, errors of solvers over 100 periods, and largest error of the period.

    Each error is the smallest over all tolerances. The error of the period is the largest over all solvers.
    """
    rows = []
    for reference in references:
        row = {
            "Problem": reference.problem_title,
            "Period": f"{Decimal(reference.period_30_digits):.{DIGITS}f}",
            "Uncertainty": f"{reference.period_certified.item():.0e}",
            "of the motion": f"{(reference.u_certified / abs(reference.u).max()).item():.0e}",
        }
        best = agreement.displacement_error.sel(problem=reference.problem, periods=100).min("tolerance")
        for route, title in _TITLES.items():
            error = best.sel(route=route).item()
            row[title] = f"{error:.0e}" if error == error else "–"
        row["Worst period"] = f"{agreement.period_error.sel(problem=reference.problem).min('tolerance').max():.0e}"
        rows.append(row)
    return pd.DataFrame(rows)
