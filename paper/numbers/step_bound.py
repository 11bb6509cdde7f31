"""Numbers of the text: errors of energy and period from the modified energy, and as measured."""

import math

import numpy as np
import xarray as xr

from paper.products import numbers
from study.words import number, span

SCHEMES = ["central_difference", "average_acceleration"]
#: Largest relative difference of measured and predicted error at which a prediction is confirmed.
CONFIRMED = 0.1


@numbers(bound="stability/step_bound")
def of_step_bound(bound: xr.Dataset) -> dict:
    """Numbers of potentials and motions, of confirmed predictions, and the steps that keep the allowed error."""
    bound = bound.sel(scheme=SCHEMES)
    predicted = bound.coefficient * bound.omega_step**2
    difference = abs(bound.error / predicted - 1)
    confirmed = difference < CONFIRMED
    missed = ~confirmed.all(["scheme", "quantity"])
    exceptions = [
        f"{motion.potential_title.item()} from {number(motion.u0.item())}"
        for _, motion in bound.isel(motion=missed.values).groupby("motion")
    ]
    periods = bound.coefficient.sel(quantity="period")
    ratio = periods.sel(scheme="average_acceleration") / periods.sel(scheme="central_difference")
    found = {
        "bound_potentials": len(np.unique(bound.potential)),
        "bound_motions": bound.sizes["motion"],
        "bound_error": f"{100 * bound.allowed_error.item():g}",
        "bound_periods": bound.periods.item(),
        "bound_confirmed": f"{100 * CONFIRMED:g}",
        "bound_runs": bound.error.sel(quantity="energy").size,
        "bound_energy_confirmed": int(confirmed.sel(quantity="energy").sum()),
        "bound_period_confirmed": int(confirmed.sel(quantity="period").sum()),
        "bound_exceptions": ", ".join(exceptions) or "none",
        "bound_period_ratio": span(ratio, ".3g"),
        "bound_most_energy": f"{100 * bound.error.sel(quantity='energy').max().item():.2g}",
    }
    for name in SCHEMES:
        convex = bound.convex_coefficient.sel(scheme=name).item()
        found[f"bound_convex_{name}"] = f"{math.floor(100 * math.sqrt(bound.allowed_error.item() / convex)) / 100:.2f}"
    return found
