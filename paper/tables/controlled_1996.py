"""Tables 1 and 2 of 1996 with equal steps and with nearly as many steps controlled by the estimator of 1991."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.published import PROBLEMS
from paper.requirements import contained


@table(
    "Tables 1 and 2 of 1996 with controlled steps",
    requires={
        "controlled_1996.problems": PROBLEMS,
        "energy_error.problems": PROBLEMS,
        "": contained("controlled_1996.steps_per_period", within="energy_error.steps_per_period"),
    },
)
def tabulate(controlled_1996: xr.Dataset, energy_error: xr.Dataset) -> pd.DataFrame:
    """Two rows per problem and step size, equal and controlled steps; one column per scheme that has the estimator."""
    controlled = 100 * controlled_1996.max_energy_error.isel(controller=0)
    estimated = controlled_1996.scheme[controlled.notnull().any(["problem", "steps_per_period"])].values
    equal = 100 * energy_error.max_energy_error.sel(period_used="exact")
    titles = dict(zip(energy_error.problem.values, energy_error.problem_title.values, strict=True))
    rows = []
    for problem in PROBLEMS:
        for steps in controlled.steps_per_period.values:
            for name, errors in (("equal", equal), ("controlled", controlled)):
                row = {"Problem": titles[problem], "Steps": f"{steps} per period", "Sizes": name}
                for scheme in estimated:
                    value = errors.sel(problem=problem, steps_per_period=steps, scheme=scheme).item()
                    row[energy_error.scheme_title.sel(scheme=scheme).item()] = f"{value:.3g}"
                rows.append(row)
    return pd.DataFrame(rows)
