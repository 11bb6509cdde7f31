"""Numbers of the text: growth of errors with the length of the run, and steps extrapolated to longer runs."""

import numpy as np
import xarray as xr

from paper.claims.error_growth import exponents
from paper.claims.wording import number
from paper.products import numbers
from study.words import span


@numbers(growth="error_growth")
def of_error_growth(growth: xr.Dataset) -> dict:
    """Exponents of growth, and the cases in which an extrapolated step keeps the error."""
    found = {}
    for kind, keeps in (("kept", 1), ("lost", 0)):
        of_kind = growth.isel(scheme=np.flatnonzero(growth.keeps_energy == keeps))
        for name, measure in (
            ("phase", "phase_error"),
            ("displacement", "max_trajectory_error"),
            ("energy", "max_energy_error"),
            ("amplitude", "amplitude_decay"),
        ):
            values = exponents(of_kind, measure).values
            values = values[np.isfinite(values)]
            found[f"growth_{name}_{kind}"] = span(values) if values.size else None
    energy = exponents(growth.isel(scheme=np.flatnonzero(growth.keeps_energy == 0)), "max_energy_error")
    found["growth_energy_lost_most"] = f"{energy.max().item():.2f}" if energy.notnull().any() else None
    ratio = (growth.extrapolated_error / growth.allowed_error).values[growth.run.notnull().values]
    return found | {
        "growth_schemes": growth.sizes["scheme"],
        "growth_longest": f"{growth.periods.values[-1].item():,}",
        "growth_known": f"{growth.known.item():,}",
        "growth_extrapolated": f"{growth.extrapolated.item():,}",
        "growth_allowed": f"{100 * growth.allowed_error.item():g}",
        "growth_cases": ratio.size,
        "growth_cases_kept": int((ratio <= 1).sum()),
        "growth_most": number(100 * (growth.allowed_error.item() * np.nanmax(ratio)), ".3g") if ratio.size else None,
    }
