"""Numbers of the text: problems with known displacements."""

import numpy as np
import xarray as xr

from paper.claims.published_numbers import largest_step, steps_of_orbit
from paper.products import numbers
from paper.terms import ROUND_OFF

_NEEDED = ["arenstorf", "van_der_pol", "loaded_bar"]


@numbers(
    requires={
        "published_numbers.coarsest.problem": _NEEDED,
        "published_numbers.controlled": ["arenstorf"],
        "published_numbers.schemes": ["average_acceleration", "central_difference", "rk4"],
    }
)
def known_displacement_numbers(published_numbers: xr.Dataset) -> dict:
    """Steps that schemes need for the known displacements."""
    orbit = steps_of_orbit(published_numbers)
    bar = published_numbers.sel(problem="loaded_bar", scheme="central_difference")
    stiff = np.array(list(largest_step(published_numbers).values()))
    plate = None
    if "thin_plate" in published_numbers.problem.values:
        fine = published_numbers.end_error.sel(problem="thin_plate").isel(refinement=-1)
        plate = f"{100 * fine.min().item():.1f}"
    return {
        **{
            f"orbit_{kind}_{name}": f"{steps[name]:,.0f}" if np.isfinite(steps[name]) else None
            for kind, steps in orbit.items()
            for name in ("average_acceleration", "rk4")
        },
        "bar_exact_steps": f"{bar.steps[bar.end_error.fillna(np.inf).argmin('refinement')].item():,}",
        "bar_is_exact": bool(bar.end_error.min() <= ROUND_OFF),
        "bar_fine_error": f"{100 * bar.end_error[-1].item():.2g}",
        "stiff_largest_step": f"{np.nanmax(stiff):.2g}" if np.isfinite(stiff).any() else None,
        "plate_differs": plate,
    }
