"""Numbers of the text: errors of energy and period from the modified energy, and as measured."""

import math

import numpy as np
import xarray as xr

from paper.claims.step_bound import CONFIRMED, LARGEST_STEP, SCHEMES, confirmed, exceptions, over_convex
from paper.products import numbers
from paper.wording import joined
from study.words import at_most, span


@numbers(bound="stability/step_bound", rule="stability/step_rule", requires={"step_rule.schemes": SCHEMES})
def step_bound_numbers(bound: xr.Dataset, rule: xr.Dataset) -> dict:
    """Numbers of potentials and motions, of confirmed predictions, and the steps that keep the allowed error."""
    over, described = over_convex(bound, rule)
    bound = bound.sel(scheme=SCHEMES)
    close = confirmed(bound)
    periods = abs(bound.measured_error.sel(quantity="period")) / bound.omega_step**2
    ratio = periods.sel(scheme="average_acceleration") / periods.sel(scheme="central_difference")
    exceptional = {name: exceptions(bound, ~close.sel(quantity=name).all("scheme")) for name in ("energy", "period")}
    values = {
        "bound_potentials": len(np.unique(bound.potential)),
        "bound_motions": bound.sizes["motion"],
        "bound_cap": f"{bound.omega_step.max().item():g}",
        "bound_error": f"{100 * bound.allowed_error.item():g}",
        "bound_periods": bound.periods.item(),
        "bound_confirmed": f"{100 * CONFIRMED:g}",
        "bound_runs": bound.measured_error.sel(quantity="energy").size,
        "bound_energy_confirmed": int(close.sel(quantity="energy").sum()),
        "bound_period_confirmed": int(close.sel(quantity="period").sum()),
        **{
            f"bound_{quantity}_exceptions": joined(missed, {}) if missed else None
            for quantity, missed in exceptional.items()
        },
        "bound_step": f"{LARGEST_STEP:g}",
        "bound_convex_runs": f"{int(described.sum()):,}",
        "bound_convex_most": f"{over.where(described).max().item():.2f}",
        "bound_period_ratio": span(ratio, ".1f"),
        "bound_most_energy": at_most(100 * bound.measured_error.sel(quantity="energy").max().item(), 2),
    }
    for name in SCHEMES:
        convex = bound.convex_coefficient.sel(scheme=name).item()
        beyond = over.where(~described).sel(scheme=name).max().item()
        values[f"bound_beyond_{name}"] = f"{beyond:.2g}" if beyond > 0 else None
        values[f"bound_convex_{name}"] = f"{math.floor(100 * math.sqrt(bound.allowed_error.item() / convex)) / 100:.2f}"
    return values
