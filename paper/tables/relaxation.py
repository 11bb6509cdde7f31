"""The Runge-Kutta method with and without relaxation, compared with its printed errors in Tables 1 and 2."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.published import PROBLEMS, STEPS, printed_energy_errors
from paper.wording import number


@table("Runge-Kutta with relaxation", requires={"relaxation.problems": PROBLEMS, "relaxation.steps_per_period": STEPS})
def tabulate(relaxation: xr.Dataset) -> pd.DataFrame:
    """One row per problem and step size."""
    printed = printed_energy_errors().sel(scheme="rk4")

    def row(problem: str, steps: int) -> dict[str, str]:
        at = relaxation.sel(problem=problem, steps_per_period=steps)
        energy, motion = 100 * at.max_energy_error, 100 * at.return_error
        return {
            "Spring": at.problem_title.item(),
            "Step": f"T/{steps}",
            "Energy, 1996": number(printed.sel(problem=problem, steps_per_period=steps).item()),
            "Energy": number(energy.sel(variant="plain").item()),
            "Energy, relaxed": number(energy.sel(variant="relaxed").item(), ".0e"),
            "Motion": number(motion.sel(variant="plain").item()),
            "Motion, relaxed": number(motion.sel(variant="relaxed").item()),
        }

    return pd.DataFrame(row(problem, steps) for problem in PROBLEMS for steps in STEPS)
