"""Stability limit in linear theory, and step sizes at which every scheme first gains energy or fails on oscillators."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.data import families
from paper.products import table
from paper.requirements import contained, rising

#: Problems with positive energy; only on these can a gain of energy be distinguished from a loss.
PROBLEMS = ["hardening", "softening", "softening_large"]
#: Excess over the initial energy, divided by this energy, above which the energy in the second half of a run has grown.
GAIN = 1.0


def _first(run: xr.Dataset) -> str:
    """Smallest step size at which the energy exceeds twice its initial value late in the run, or the run fails.

    Late means in the second half. A failure is marked by N if a step has no solution, and otherwise by ∞. A dash means
    that all step sizes are small enough.
    """
    gained, failed = run.late_energy_gain.values > GAIN, run.status.values != 0
    if not (gained | failed).any():
        return "–"
    at = int(np.argmax(gained | failed))
    meanings = run.status.flag_meanings.split()
    how = {"no_solution_found": " N"}.get(meanings[int(run.status.values[at])], " ∞" if failed[at] else "")
    return f"{run.step_size_over_period.values[at]:g}{how}"


@table(
    "Stability limits in linear theory and on oscillators",
    requires={
        "": contained("large_steps.schemes", within="spectral.schemes"),
        "spectral.damping_ratios": [0.0],
        "large_steps.problems": PROBLEMS,
        "large_steps.step_size_over_period": rising,
    },
)
def tabulate(spectral: xr.Dataset, large_steps: xr.Dataset) -> pd.DataFrame:
    """One row per scheme: the linear limit of Δt/T, and the first step size that is too large on each problem."""
    limits = spectral.stability_limit.sel(damping_ratio=0.0) / (2 * np.pi)
    rows = []
    for part in families(large_steps.sel(problem=PROBLEMS)).values():
        for name in part.scheme.values:
            limit = limits.sel(scheme=name).item()
            row = {
                "Scheme": part.scheme_title.sel(scheme=name).item(),
                "Linear limit": "none" if np.isinf(limit) else f"{limit:.3f}",
            }
            for problem, title in zip(part.problem.values, part.problem_title.values, strict=True):
                row[title[0].upper() + title[1:]] = _first(part.sel(scheme=name, problem=problem))
            rows.append(row)
    return pd.DataFrame(rows)
