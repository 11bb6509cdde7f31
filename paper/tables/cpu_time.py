"""Time per step in nanoseconds, and its ratio to the time of average acceleration next to the ratio of 1996."""

import pandas as pd
import xarray as xr

from paper.products import table
from paper.published import PROBLEMS, SCHEMES, printed_cpu_times


@table("Time of a step", requires={"cpu_time.schemes": SCHEMES, "cpu_time.problems": PROBLEMS})
def tabulate(cpu_time: xr.Dataset) -> pd.DataFrame:
    """One row per problem and scheme of 1996."""
    seconds = printed_cpu_times()
    printed_ratio = seconds / seconds.sel(scheme="average_acceleration")
    cpu_time = cpu_time.sel(scheme=seconds.scheme, problem=seconds.problem)
    rows = []
    for problem in cpu_time.problem.values:
        for scheme in cpu_time.scheme.values:
            cell = {"problem": problem, "scheme": scheme}
            now = cpu_time.sel(cell)
            rows.append(
                {
                    "Problem": now.problem_title.item(),
                    "Scheme": now.scheme_title.item(),
                    "1996 (s)": f"{seconds.sel(cell).item():.2f}",
                    "Ratio of 1996": f"{printed_ratio.sel(cell).item():.2f}",
                    "Now (ns per step)": f"{1e9 * now.median_seconds_per_step.item():.1f}",
                    "Spread (ns)": f"{1e9 * now.spread_of_seconds_per_step.item():.1f}",
                    "Ratio now": f"{now.ratio.item():.2f} ({now.ratio_low.item():.2f} to {now.ratio_high.item():.2f})",
                }
            )
    return pd.DataFrame(rows)
