"""Numbers of the text: the largest safe step times the highest frequency of the motion."""

import math

import xarray as xr

from paper.data import largest_omega_step
from paper.products import numbers
from paper.wording import joined
from study.words import number

#: Allowed relative error of energy and period.
ERROR = 0.01
SCHEMES = ["central_difference", "average_acceleration", "rk4"]
#: Ratio of the largest to the smallest safe Δt ωmax of a scheme above which no rule for Δt ωmax holds.
NO_RULE = 3.0


@numbers(rule="stability/step_rule", requires={"step_rule.schemes": SCHEMES})
def step_rule_numbers(rule: xr.Dataset) -> dict:
    """Largest safe Δt ωmax of each scheme: its range over springs and amplitudes, and the range of steps per period."""
    everywhere = ["problem", "amplitude"]
    safe = largest_omega_step(rule, ERROR)
    steps = rule.period * rule.highest_frequency / safe
    everywhere_safe, most = safe.min(everywhere), safe.max(everywhere)
    # a single amplitude may allow more than its neighbours, where the error varies irregularly with the step
    most_of_neighbours = safe.rolling(amplitude=min(2, safe.sizes["amplitude"])).min().max(everywhere)
    fewest, finest = steps.min(everywhere), steps.max(everywhere)
    ratio = most / everywhere_safe
    printed = {name: math.floor(100 * everywhere_safe.sel(scheme=name).item()) / 100 for name in SCHEMES}
    entries = {
        "rule_error": f"{100 * ERROR:g}",
        "rule_periods": f"{rule.periods.item():,}",
        "rule_amplitudes": rule.sizes["amplitude"],
        "rule_tried": int((rule.omega_step <= everywhere_safe.sel(scheme=SCHEMES[:2]).min()).sum()),
        "rule_smallest": number(rule.amplitude.min().item(), 2),
        "rule_largest": number(rule.amplitude.max().item(), 2),
        "rule_serves": bool(((ratio < NO_RULE) & (ratio < finest / fewest)).sel(scheme=SCHEMES).all()),
        "rule_exceptions": joined(rule.scheme_title.values[(ratio > NO_RULE).values], {}),
    }
    for name in SCHEMES:
        entries |= {
            f"rule_below_{name}": f"{printed[name]:.2f}",
            f"rule_most_{name}": f"{most_of_neighbours.sel(scheme=name).item():.2f}",
            f"rule_steps_{name}": f"{number(fewest.sel(scheme=name).item(), 2)} to "
            + number(finest.sel(scheme=name).item(), 2),
        }
    return entries
