"""Numbers of the text: the step by the highest frequency of the motion."""

import math

import xarray as xr

from paper.data import keeps, largest_safe
from paper.products import numbers

#: Allowed error of energy and period in percent.
ERROR = 1.0
SCHEMES = ["central_difference", "average_acceleration", "rk4"]
#: Ratio of the largest to the smallest Δt ωmax from which on it is no rule.
NO_RULE = 3.0


@numbers(atlas="stability/atlas", asks={"atlas.schemes": SCHEMES})
def of_step_rule(atlas: xr.Dataset) -> dict:
    """Δt ωmax below which all runs of the maps keep energy and period and above which none does, and their steps."""
    everywhere = ["problem", "amplitude"]
    stiffness = atlas.period * atlas.highest_frequency
    safe, by_frequency = largest_safe(atlas, ERROR), atlas.dt_over_period * stiffness
    all_safe = by_frequency.where(~keeps(atlas, ERROR)).min([*everywhere, "dt_over_period"])
    most = (safe * stiffness).max(everywhere)
    tested = (by_frequency.min("dt_over_period") < all_safe).mean(everywhere)
    fewest, finest = 1 / safe.max(everywhere), 1 / atlas.dt_over_period.min().item()
    exceptions = ((safe > 0).mean(everywhere) > 0.5) & (most / all_safe > NO_RULE)
    found = {
        "rule_error": f"{ERROR:g}",
        "rule_tested": f"{100 * tested.sel(scheme=SCHEMES).min().item():.0f}",
        "rule_serves": bool(
            ((most / all_safe < NO_RULE) & (most / all_safe < finest / fewest)).sel(scheme=SCHEMES).all()
        ),
        "rule_exceptions": ", ".join(atlas.scheme_title.values[exceptions.values]) or "none",
    }
    for name in SCHEMES:
        least = safe.sel(scheme=name).min().item()
        found |= {
            f"rule_below_{name}": f"{math.floor(100 * all_safe.sel(scheme=name).item()) / 100:.2f}",
            f"rule_most_{name}": f"{most.sel(scheme=name).item():.2f}",
            f"rule_steps_{name}": f"{fewest.sel(scheme=name).item():.0f} to "
            + (f"{1 / least:.0f}" if least else f"more than {finest:.0f}"),
        }
    return found
