"""Steps for the whole motion, compared with those for the displacement alone."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.tables.decision import sentence

#: Allowed error of the displacement.
ERROR = 0.1
#: Schemes whose steps are compared.
SHOWN = ["central_difference", "average_acceleration", "generalized_alpha", "bathe"]


def _steps(need: xr.Dataset) -> str:
    return f"{need.steps_per_period.item():,.1f}".removesuffix(".0") if need.step_size > 0 else "–"


@table(
    "Steps for the displacement and for the whole motion",
    requires={"runs.schemes": SHOWN[:2], "runs.allowed_errors": [ERROR]},
)
def tabulate(needs: xr.Dataset) -> pd.DataFrame:
    """One row per problem on which a scheme needs other steps for :data:`study.runs.needs.WHOLE_MOTION`.

    A cell has the steps in a period for the displacement alone and for the whole motion.
    """
    at = needs.sel(allowed_error=ERROR, quantity="displacement")
    at = at.sel(scheme=[name for name in SHOWN if name in at.scheme.values])
    rows = []
    for problem in at.problem.values:
        needed = at.sel(problem=problem)
        row = {"Problem": sentence(needed.problem_title.item())}
        for name in needed.scheme.values:
            alone, whole = (_steps(needed.sel(scheme=name, condition=of)) for of in ("practice", "whole_motion"))
            row[needed.scheme_title.sel(scheme=name).item()] = alone if alone == whole else f"{alone} / {whole}"
        if any("/" in cell for cell in row.values()):
            rows.append(row)
    return pd.DataFrame(rows, columns=["Problem", *at.scheme_title.values])
