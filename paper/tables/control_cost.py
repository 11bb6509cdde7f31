"""Force evaluations for an error of 1 % of the displacement: with controlled and equal steps, and with solvers."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import SOLVERS, fewest
from paper.measures.step_control import ALLOWED, with_control
from paper.products import table


@table("Forces for one percent of error with controlled and with equal steps")
def tabulate(control_cost: xr.Dataset, solver_cost: xr.Dataset) -> pd.DataFrame:
    """One row per scheme, with force evaluations for each problem (controlled / equal steps), then one per solver."""
    controlled, equal = with_control(control_cost, ALLOWED)
    of_solvers = fewest(solver_cost.error, solver_cost.force_evaluations, ALLOWED, "tolerance")
    titles = dict(zip(control_cost.problem.values, control_cost.problem_title.values, strict=True))
    rows = []
    for scheme in control_cost.scheme.values:
        row = {"Scheme": control_cost.scheme_title.sel(scheme=scheme).item()}
        for problem, title in titles.items():
            both = (one.sel(problem=problem, scheme=scheme) for one in (controlled, equal))
            row[title] = " / ".join(map(_forces, both))
        rows.append(row)
    for solver in solver_cost.solver.values:
        row = {"Scheme": SOLVERS[solver]}
        for problem in solver_cost.problem.values:
            row[titles[problem]] = _forces(of_solvers.sel(problem=problem, solver=solver))
        rows.append(row)
    return pd.DataFrame(rows).fillna("–")


def _forces(value: xr.DataArray) -> str:
    return "–" if np.isnan(value) else f"{value.item():,.0f}"
