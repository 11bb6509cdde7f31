"""Steps a period that keep the energy of every scheme within 1, 5 and 10 percent at all amplitudes."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.tables.writing import main


def _steps(value: float, most: int) -> str:
    return f"> {most}" if np.isnan(value) else f"{value:.0f}"


def tabulate(robustness: xr.Dataset) -> pd.DataFrame:
    """One row a scheme and length of the run, the levels of each problem side by side."""
    most = int(robustness.most_steps)
    rows = []
    for scheme in robustness.scheme.values:
        for length in robustness.periods.values:
            one = robustness.steps_needed.sel(scheme=scheme, periods=length)
            first = length == robustness.periods.values[0]
            row = {
                "Scheme": robustness.scheme_title.sel(scheme=scheme).item() if first else "",
                "Periods": f"{length:,}",
            }
            for problem, title in zip(robustness.problem.values, robustness.problem_title.values, strict=True):
                for level in robustness.level.values:
                    row[f"{title.split()[0].capitalize()} {level} %"] = _steps(
                        one.sel(problem=problem, level=level).item(), most
                    )
            rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main(tabulate)
