"""The fastest scheme for an allowed error, by quantity, and its steps in a period."""

import pandas as pd
import xarray as xr

from paper.data import ASSESSED, fastest, steps_of_period
from paper.picks import AT_MOST, COARSEST, sentence
from paper.products import table
from paper.requirements import OF_THE_ASSESSMENTS
from study.analysis.recommendation import recommend


def _cell(spring: xr.Dataset, error: float, quantity: str) -> str:
    """The fastest scheme with its steps; if schemes tie, the one with the fewest evaluations, marked by an asterisk."""
    needs = fastest(recommend(spring, error=error, quantity=quantity))
    if needs.empty:
        return "–"
    best = needs.iloc[0]
    at_most = AT_MOST if best.verdict == COARSEST else ""
    title = spring.scheme_title.sel(scheme=best.name).item()
    tied = "\u00a0*" if len(needs) > 1 else ""
    return f"{title}: {at_most}{steps_of_period(spring, best.step_size):,}{tied}"


@table("Fastest schemes by quantity and error", springs=ASSESSED, requires=OF_THE_ASSESSMENTS)
def tabulate(springs: list[xr.Dataset]) -> pd.DataFrame:
    """One row per spring and error; a dash where no scheme keeps the error."""
    return pd.DataFrame(
        {"Problem": sentence(spring.attrs["problem"]), "Error": f"{100 * error:g} %"}
        | {quantity.capitalize(): _cell(spring, error, quantity) for quantity in spring.quantity.values}
        for spring in springs
        for error in spring.allowed_error.values
    )
