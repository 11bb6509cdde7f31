"""Numbers of the text: forces that yield, remember and touch."""

import xarray as xr

from paper.asks import fourfold
from paper.printing import span
from paper.products import numbers

#: Problems with a history, and those with any kink but contact.
REMEMBER = ["yielding", "hysteretic"]
KINKED = [*REMEMBER, "shaken"]
#: Below this order a method of fourth order has lost it; above this ratio of errors it still gains.
LOST, GAINED = 3.0, 1.5
#: Percent of the energy below which its balance is kept.
KEPT = 0.01


def _orders(kinks: xr.Dataset, problem: str, *schemes: str) -> str:
    """Observed orders, from the smallest to the largest."""
    return span(kinks.observed_order.sel(problem=problem, scheme=list(schemes)), ".1f")


@numbers(
    kinks="kinks",
    asks={
        "kinks.problems": ["hardening", "yielding", "hysteretic", "bouncing", "shaken"],
        "kinks.schemes": ["average_acceleration", "central_difference", "rk4", "yoshida4"],
        "kinks.steps_per_period": fourfold("kinks.steps_per_period"),
    },
)
def of_kinks(kinks: xr.Dataset) -> dict:
    """Orders on kinks, and what an expensive scheme still gains."""
    coarsest = kinks.isel(steps_per_period=0)
    of_two = [name for name in kinks.scheme.values if kinks.order.sel(scheme=name) >= 2]
    of_rk4 = kinks.observed_order.sel(scheme="rk4", problem=KINKED)
    average, rk4 = (coarsest.error.sel(scheme=name) for name in ("average_acceleration", "rk4"))
    gain = {p: float(average.sel(problem=p) / rk4.sel(problem=p)) for p in ("hardening", *KINKED)}
    # a step of the Runge-Kutta method takes four forces, one of central difference takes one
    at_equal_forces = kinks.error.sel(scheme="central_difference", steps_per_period=4 * coarsest.steps_per_period)
    equal = {p: float(at_equal_forces.sel(problem=p) / rk4.sel(problem=p)) for p in KINKED}
    highest = kinks.observed_order.sel(problem=KINKED).max()
    balance = coarsest.max_energy_imbalance.sel(problem=REMEMBER, scheme="average_acceleration")
    return {
        "order_lost_on_kinks": bool((of_rk4 < LOST).all()),
        "accuracy_kept_on_kinks": min(gain[p] for p in KINKED) > GAINED,
        **{f"kinks_equal_{p}": f"{ratio:.2g}" for p, ratio in equal.items()},
        "kinks_highest_order": f"{float(highest):.1f}",
        "balance_is_no_verdict": bool(
            balance.max() < KEPT and average.sel(problem="yielding") > 1e4 * balance.max() / 100
        ),
        "kinks_rk4_smooth": _orders(kinks, "hardening", "rk4"),
        "kinks_rk4_yielding": _orders(kinks, "yielding", "rk4"),
        "kinks_rk4_hysteretic": _orders(kinks, "hysteretic", "rk4"),
        "kinks_rk4_shaken": _orders(kinks, "shaken", "rk4"),
        "kinks_yoshida": _orders(kinks, "yielding", "yoshida4"),
        "kinks_average": _orders(kinks, "yielding", "average_acceleration"),
        "kinks_bouncing": _orders(kinks, "bouncing", *of_two),
        "kinks_steps": int(kinks.steps_per_period[0]),
        "kinks_gain_smooth": f"{gain['hardening']:.0f}",
        "kinks_gain_yielding": f"{gain['yielding']:.0f}",
        "kinks_gain_hysteretic": f"{gain['hysteretic']:.0f}",
        "kinks_gain_shaken": f"{gain['shaken']:.1f}",
        "kinks_error": f"{100 * average.sel(problem='yielding').item():.2g}",
        "kinks_balance": f"{float(balance.max()):.0e}",
    }
