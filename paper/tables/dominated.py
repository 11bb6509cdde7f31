"""Cost of each scheme, and the schemes that dominate it in all respects measured."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.measures.respects import costs, respects
from paper.products import table
from paper.wording import joined, number
from study.runs.needs import dominated


@table("Dominated schemes", requires={"spectral.damping_ratios": [0.0]})
def tabulate(needs: xr.Dataset, spectral: xr.Dataset) -> pd.DataFrame:
    """One row per scheme: number of problems on which a step keeps the error, median cost, and dominating schemes."""
    forces = costs(needs)
    kept = respects(forces, spectral)
    rows = []
    for name in forces.scheme.values:
        cost, others = forces.sel(scheme=name), dominated(kept, name)
        rows.append(
            {
                "Scheme": forces.scheme_title.sel(scheme=name).item(),
                "Problems": f"{int(cost.notnull().sum())} of {cost.size}",
                # where no step keeps the error, the cost is infinite: a scheme that fails on hard problems is not cheap
                "Forces, median": number(cost.fillna(np.inf).median().item(), ".0f"),
                "Dominated by": joined(others, {"spectral": spectral}) if others else "–",
            }
        )
    return pd.DataFrame(rows)
