"""Numbers of the text: problems with known displacements, and chaos of Ueda's oscillator."""

import numpy as np
import xarray as xr

from paper.claims.published_numbers import fewest_steps, largest_step, orders_of_means, steps_of_orbit
from paper.claims.terms import FAITHFUL, ROUND_OFF
from paper.products import numbers
from study.words import listed, span

_NEEDED = ["arenstorf", "van_der_pol", "loaded_bar"]


@numbers(
    requires={
        "published_numbers.coarsest.problem": _NEEDED,
        "published_numbers.controlled": ["arenstorf"],
        "published_numbers.schemes": ["average_acceleration", "central_difference", "rk4"],
    }
)
def of_published_numbers(published_numbers: xr.Dataset, ueda: xr.Dataset) -> dict:
    """Steps that schemes need for the known displacements and for the Lyapunov exponent of Ueda's oscillator."""
    orbit = steps_of_orbit(published_numbers)
    bar = published_numbers.sel(problem="loaded_bar", scheme="central_difference")
    stiff = np.array(list(largest_step(published_numbers).values()))
    fewest = np.array(list(fewest_steps(ueda).values()))
    last = ueda.where(ueda.exponent > 0).isel(steps_per_period=-1)
    exact = last.sel(scheme="rk4")
    orders = {name: orders_of_means(ueda)[name] for name in FAITHFUL}

    def regular(name: str) -> list[int]:
        return ueda.steps_per_period.values[(ueda.exponent.sel(scheme=name) < 0).values].tolist()

    plate = None
    if "thin_plate" in published_numbers.problem.values:
        fine = published_numbers.error.sel(problem="thin_plate").isel(refinement=-1)
        plate = f"{100 * fine.min().item():.1f}"
    return {
        **{
            f"orbit_{kind}_{name}": f"{steps[name]:,.0f}" if np.isfinite(steps[name]) else None
            for kind, steps in orbit.items()
            for name in ("average_acceleration", "rk4")
        },
        "bar_exact_steps": f"{bar.steps[bar.error.fillna(np.inf).argmin('refinement')].item():,}",
        "bar_is_exact": bool(bar.error.min() <= ROUND_OFF),
        "bar_fine_error": f"{100 * bar.error[-1].item():.2g}",
        "stiff_largest_step": f"{np.nanmax(stiff):.2g}" if np.isfinite(stiff).any() else None,
        "plate_differs": plate,
        "ueda_printed": f"{ueda.printed_exponent.item():.4f}",
        "ueda_steps": span(fewest[np.isfinite(fewest)], ".0f") if np.isfinite(fewest).any() else None,
        "ueda_finest": span(last.exponent, ".3f"),
        "ueda_uncertainty": f"{last.uncertainty.max().item():.0e}",
        "ueda_periods": f"{ueda.attrs['periods']:,}",
        "ueda_mean_square": f"{exact.mean_square.item():.4g}",
        "ueda_mean_square_uncertainty": f"{exact.mean_square_uncertainty.item():.0e}",
        **{
            f"ueda_order_{name}": f"{order:.1f} ± {error:.1f}" if np.isfinite(order) else None
            for name, (order, error) in orders.items()
        },
        "ueda_converges": all(np.isfinite(order) for order, _ in orders.values()),
        "ueda_regular": ", ".join(
            f"{ueda.scheme_title.sel(scheme=name).item()} with {listed(map(str, regular(name)))} steps"
            for name in ueda.scheme.values
            if len(regular(name))
        )
        or "none",
    }
