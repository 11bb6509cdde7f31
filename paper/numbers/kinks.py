"""Numbers of the text: forces with yielding, memory and contact."""

import numpy as np
import xarray as xr

from paper.measures.kinks import GAINED, KINKED, LOST, REMEMBER, at_equal_forces
from paper.products import numbers
from paper.requirements import fourfold
from study.words import listed, number, span

#: Error of the balance of energies, in percent of the energy, below which the balance counts as kept.
KEPT = 0.01
#: Smallest number of steps in a period that resolves the motion.
RESOLVED = 64
#: Forces of a step of the Runge-Kutta method, and so the number of steps of central difference that cost as much.
FORCES = 4


def _orders(kinks: xr.Dataset, problem: str, *schemes: str) -> str:
    """Range of the observed orders of some schemes, as whole numbers because errors at kinks decrease irregularly."""
    return span(kinks.observed_order.sel(problem=problem, scheme=list(schemes)), ".0f")


@numbers(
    reference="reference/inelastic",
    requires={
        "kinks.problems": ["hardening", "yielding", "hysteretic", "bouncing", "shaken"],
        "kinks.schemes": ["average_acceleration", "central_difference", "rk4", "yoshida4"],
        "kinks.steps_per_period": fourfold,
    },
)
def kink_numbers(kinks: xr.Dataset, reference: xr.Dataset) -> dict:
    """Observed orders with kinks, and the gain in accuracy that Runge-Kutta keeps, at steps that resolve the motion."""
    kinks = kinks.isel(steps_per_period=np.flatnonzero(kinks.steps_per_period.values >= RESOLVED))
    coarsest = kinks.isel(steps_per_period=0)
    second_order = [name for name in kinks.scheme.values if kinks.order.sel(scheme=name) >= 2]
    rk4_order = kinks.observed_order.sel(scheme="rk4", problem=KINKED)
    average, rk4 = (kinks.sampled_error.sel(scheme=name) for name in ("average_acceleration", "rk4"))
    gain = {p: (average / rk4).sel(problem=p) for p in ("hardening", *KINKED)}
    equal = at_equal_forces(kinks).sel(problem=KINKED).dropna("steps_per_period")
    dividing = kinks.sel(problem="shaken")
    average_dividing, rk4_dividing = (
        dividing.dividing_sampled_error.sel(scheme=s) for s in ("average_acceleration", "rk4")
    )
    meets = [k for k in kinks.steps_per_spacing.values if FORCES * k in kinks.steps_per_spacing]
    central = dividing.dividing_sampled_error.sel(
        scheme="central_difference", steps_per_spacing=[FORCES * k for k in meets]
    )
    equal_dividing = central.values / rk4_dividing.sel(steps_per_spacing=meets).values
    fitted = kinks.observed_order.sel(problem="bouncing", scheme=second_order)
    unfitted = fitted.scheme_title.values[fitted.isnull().values]
    average_on_yielding = {"problem": "yielding", "scheme": "average_acceleration"}
    balance = 100 * coarsest.max_energy_imbalance.sel(problem=REMEMBER, scheme="average_acceleration")
    dissipating = kinks.sampled_error.sel(problem=REMEMBER)
    return {
        "momentum_method_needs_a_potential": bool(
            "energy_momentum" in kinks.scheme and dissipating.sel(scheme="energy_momentum").isnull().all()
        ),
        "order_lost_on_kinks": bool((rk4_order < LOST).all()),
        "accuracy_kept_on_kinks": all(bool((gain[p] > GAINED).all()) for p in KINKED),
        **{f"kinks_equal_{p}": span(equal.sel(problem=p), ".2g") for p in KINKED},
        "kinks_equal_dividing": span(equal_dividing, ".2g") if meets else None,
        "kinks_equal_finest": int(equal.steps_per_period.max()),
        "balance_is_no_verdict": bool(
            balance.max() < KEPT and coarsest.sampled_error.sel(average_on_yielding) > 1e4 * balance.max() / 100
        ),
        "kinks_periods": f"{reference.sample.max().item():.0f}",
        "kinks_rk4_smooth": _orders(kinks, "hardening", "rk4"),
        "kinks_rk4_yielding": _orders(kinks, "yielding", "rk4"),
        "kinks_rk4_hysteretic": _orders(kinks, "hysteretic", "rk4"),
        "kinks_rk4_shaken": _orders(kinks, "shaken", "rk4"),
        "kinks_rk4_dividing": span(dividing.dividing_order.sel(scheme=["rk4"]), ".0f"),
        "kinks_average_dividing": span(dividing.dividing_order.sel(scheme=["average_acceleration"]), ".0f"),
        "dividing_keeps_the_order": bool(dividing.dividing_order.sel(scheme="rk4") > LOST),
        "kinks_gain_dividing": number((average_dividing / rk4_dividing)[0].item(), 2),
        "kinks_error_dividing": f"{100 * rk4_dividing[0].item():.2g}",
        "kinks_spacing_parts": f"{int(kinks.steps_per_spacing[0])}",
        "kinks_yoshida": _orders(kinks, "yielding", "yoshida4"),
        "kinks_average": _orders(kinks, "yielding", "average_acceleration"),
        "kinks_without_order": listed(unfitted) if len(unfitted) else None,
        "kinks_bouncing": _orders(kinks, "bouncing", *second_order),
        "kinks_steps": int(kinks.steps_per_period[0]),
        "kinks_finest": f"{int(kinks.steps_per_period[-1]):,}",
        "kinks_gain_smooth": f"{gain['hardening'][0].item():.0f}",
        **{f"kinks_gain_{p}": span(gain[p], ".2g") for p in KINKED},
        "kinks_error": f"{100 * coarsest.sampled_error.sel(average_on_yielding).item():.2g}",
        "kinks_balance": f"{float(balance.max()):.0e}",
    }
