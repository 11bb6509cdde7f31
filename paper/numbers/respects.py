"""Numbers of the text: cost at one percent of error, and schemes that another dominates."""

import xarray as xr

from paper.claims.wording import joined
from paper.products import numbers
from paper.respects import ALLOWED, costs, respects
from study.runs.needs import dominated


@numbers(requires={"spectral.damping_ratios": [0.0]})
def of_respects(needs: xr.Dataset, spectral: xr.Dataset) -> dict:
    """Schemes that keep the error on all problems, schemes that are the cheapest on some, and dominated schemes."""
    forces = costs(needs)
    of, data = respects(forces, spectral), {"spectral": spectral}
    names = forces.scheme.values
    worse = [name for name in names if dominated(of, name)]
    everywhere = names[forces.notnull().all("problem").values]
    cheapest = forces.dropna("problem", how="all").idxmin("scheme").values.tolist()
    return {
        "respects_schemes": len(names),
        "respects_problems": forces.sizes["problem"],
        "respects_error": f"{100 * ALLOWED:g}",
        "respects_dominated": joined(worse, data),
        "respects_everywhere": joined(everywhere, data),
        "respects_cheapest": joined(sorted(set(cheapest), key=lambda name: -cheapest.count(name)), data),
    }
