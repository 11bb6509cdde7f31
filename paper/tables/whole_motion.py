"""What the whole motion costs beside the displacement alone."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.tables.decision import sentence, steps_of
from paper.tables.models import ERROR
from study.words import number


def _cheapest(decisions: xr.Dataset) -> xr.Dataset:
    """The decision of the kind with the fewest evaluations of the force."""
    return decisions.isel(kind=decisions.force_evaluations.fillna(float("inf")).argmin("kind").item())


@table("What the whole motion costs")
def tabulate(decisions: xr.Dataset) -> pd.DataFrame:
    """One row per problem on which :data:`study.runs.needs.WHOLE_MOTION` needs another scheme or step."""
    at = decisions.sel(allowed_error=ERROR, method="nearest").sel(quantity="displacement")
    rows = []
    for problem in at.problem.values:
        alone, whole = (_cheapest(at.sel(problem=problem, filter=name)) for name in ("all", "whole_motion"))
        ratio = (whole.force_evaluations / alone.force_evaluations).item()
        if not alone.step_size > 0 or ratio == 1:
            continue
        row = {"Problem": sentence(alone.problem_title.item())}
        for one, name in ((alone, "displacement"), (whole, "whole motion")):
            known = bool(one.step_size > 0)
            row[sentence(name)] = one.scheme_title.item() if known else "–"
            row[f"Steps, {name}"] = steps_of(one) if known else ""
            row[f"Forces, {name}"] = f"{one.force_evaluations.item() * one.time_scale.item():,.0f}" if known else ""
        rows.append(row | {"Ratio": number(ratio, 2) if ratio > 0 else "–"})
    return pd.DataFrame(rows)
