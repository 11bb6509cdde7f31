"""Numbers of the text: growth of errors with the length of the run, and steps extrapolated to longer runs."""

import numpy as np
import xarray as xr

from paper.claims.error_growth import FROM, exponents
from paper.products import numbers
from paper.wording import number
from study.words import listed, span

#: Measure of each number, and whether it is that of the schemes that keep the energy.
EXPONENTS = {
    "growth_phase_kept": ("phase_error", 1),
    "growth_phase_lost": ("phase_error", 0),
    "growth_displacement_kept": ("displacement_error", 1),
    "growth_energy_kept": ("max_energy_error", 1),
    "growth_energy_lost": ("max_energy_error", 0),
    "growth_amplitude_lost": ("amplitude_decay", 0),
}


def _middle(values: np.ndarray) -> str | None:
    """The median of some exponents and, if they differ, their range."""
    if not values.size:
        return None
    middle, both = f"{np.median(values):.2f}", span(values)
    return (middle if middle == both else f"{middle} ({both})").replace("-", "−")


@numbers(growth="error_growth")
def error_growth_numbers(growth: xr.Dataset) -> dict:
    """Exponents of growth, and the cases in which an extrapolated step keeps the error."""
    entries = {}
    for name, (measure, keeps) in EXPONENTS.items():
        chosen = np.flatnonzero(np.isinf(growth.order_of_loss) == keeps)
        values = exponents(growth.isel(scheme=chosen), measure).values
        entries[name] = _middle(values[np.isfinite(values)])
    ratio = (growth.extrapolated_error / growth.allowed_error).values[
        growth.extrapolated_steps_per_period.notnull().values
    ]
    by_law = growth.fewest_steps_per_period * (growth.extrapolated / growth.known) ** growth.exponent
    finer = (growth.extrapolated_steps_per_period / by_law).max().item() - 1
    return entries | {
        "growth_steps": listed(f"{steps:g}" for steps in growth.steps_per_period.values),
        "growth_schemes": growth.sizes["scheme"],
        "growth_from": FROM,
        "growth_longest": f"{growth.periods.values[-1].item():,}",
        "growth_known": f"{growth.known.item():,}",
        "growth_extrapolated": f"{growth.extrapolated.item():,}",
        "growth_allowed": f"{100 * growth.allowed_error.item():g}",
        "growth_finer": f"{100 * finer:.0f}" if ratio.size else None,
        "growth_cases": ratio.size,
        "growth_cases_kept": int((ratio <= 1).sum()),
        "growth_most": number(100 * (growth.allowed_error.item() * np.nanmax(ratio)), ".3g")
        if (ratio > 0).any()
        else None,
    }
