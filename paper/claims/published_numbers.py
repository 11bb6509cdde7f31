"""Claims on problems whose solution is published or exact."""

import numpy as np
import xarray as xr

from paper.claims.ledger import PRACTICE, STUDY, Finding, by_name, claim, when
from paper.claims.terms import FAITHFUL, GREATLY, REASONABLE, ROUND_OFF, RULE
from paper.claims.wording import listed, number
from paper.data import fewest

#: Small parameter ε of van der Pol's oscillator, its shortest time scale.
FASTEST = 1e-6
#: Largest relative error of the displacement at the end of an orbit that counts as closed.
CLOSED = 0.01
#: Largest difference from two of an observed order that counts as second order.
NEARLY_TWO = 0.3


@claim(
    "structures",
    "Central difference gives the exact motion of a linear bar if a wave crosses one element per step.",
    "least error of the displacement over all steps, and the number of steps",
    whose="Belytschko et al. (2000)",
    requires={
        "published_numbers.coarsest.problem": ["loaded_bar"],
        "published_numbers.schemes": ["central_difference"],
    },
)
def exact_on_a_bar(published_numbers):
    bar = published_numbers.sel(problem="loaded_bar")
    error = bar.error.sel(scheme="central_difference")
    steps = bar.steps[error.fillna(np.inf).argmin("refinement")].item()
    holds = float(error.min()) <= ROUND_OFF
    reason = when(not holds, "a wave crosses one element in none of the steps that were tried")
    return Finding(f"{number(error.min().item(), '.0g')} at {steps}", holds, reason)


def steps_of_orbit(published_numbers: xr.Dataset) -> dict[str, dict[str, float]]:
    """Fewest equal and controlled steps from which on all runs close Arenstorf's orbit, by scheme; NaN without them."""
    orbit = published_numbers.sel(problem="arenstorf")
    equal = fewest(orbit.error, orbit.steps, CLOSED, "refinement")
    controlled = fewest(orbit.controlled_error, orbit.controlled_steps, CLOSED, "tolerance")
    return {"equal": by_name(equal), "controlled": by_name(controlled)}


@claim(
    "adaptive",
    "Step control closes Arenstorf's orbit with far fewer steps.",
    "ratio of the fewest equal to the fewest controlled steps of Runge-Kutta that close the orbit within one percent",
    whose="Hairer et al. (1993)",
    requires={
        "published_numbers.coarsest.problem": ["arenstorf"],
        "published_numbers.controlled": ["arenstorf"],
        "published_numbers.schemes": ["rk4"],
    },
)
def fewer_controlled_steps(published_numbers):
    equal, controlled = (steps["rk4"] for steps in steps_of_orbit(published_numbers).values())
    if np.isnan(controlled):
        return Finding("none", False, "no tolerance that was tried closes the orbit")
    if np.isnan(equal):
        return Finding("none equal", True, "no number of equal steps that was tried closes the orbit")
    holds = equal / controlled >= GREATLY
    return Finding(number(equal / controlled, ".0f"), holds, when(not holds, "the saving is smaller"))


def largest_step(published_numbers: xr.Dataset) -> dict[str, float]:
    """Largest Δt/ε at and below which errors on van der Pol's oscillator are reasonable, by implicit scheme, or NaN."""
    one = published_numbers.sel(problem="van_der_pol")
    one = one.isel(scheme=np.flatnonzero(one.explicit.values == 0))
    return by_name(one.time / fewest(one.error, one.steps, REASONABLE / 100, "refinement") / FASTEST)


@claim(
    "structures",
    "The step of an implicit scheme can far exceed the shortest time scale of a stiff problem.",
    f"largest step with an error up to {REASONABLE:g} % on van der Pol's oscillator, over ε, of implicit schemes",
    whose=PRACTICE,
    requires={
        "published_numbers.coarsest.problem": ["van_der_pol"],
        "published_numbers.schemes": ["average_acceleration"],
    },
)
def beyond_the_fastest_time(published_numbers):
    steps = largest_step(published_numbers)
    most = np.nanmax([0.0, *steps.values()])
    reason = when(most <= GREATLY, "its jumps last about ε, and equal steps must resolve them")
    return Finding(number(most, ".2g", "none"), bool(most > GREATLY), reason)


def _onwards(kept: xr.DataArray) -> xr.DataArray:
    """Whether a condition holds at a number of steps and at all larger ones."""
    finest_first = {"steps_per_period": slice(None, None, -1)}
    return kept.isel(finest_first).cumprod("steps_per_period").astype(bool).isel(finest_first)


def fewest_steps(ueda: xr.Dataset) -> dict[str, float]:
    """Fewest steps per period, by scheme, from which on the Lyapunov exponent stays close to the printed one.

    The value is NaN if the exponent with the most steps is not close.
    """
    onwards = _onwards(100 * abs(ueda.exponent / ueda.printed_exponent - 1) <= REASONABLE)
    return {name: onwards.steps_per_period.where(onwards.sel(scheme=name)).min().item() for name in ueda.scheme.values}


@claim(
    "structures",
    "Twenty steps per period of the load preserve the chaos of an oscillator.",
    "fewest steps at and above which the Lyapunov exponent of Ueda's oscillator is within "
    f"{REASONABLE:g} % of the printed one",
    whose=PRACTICE,
)
def twenty_steps_keep_chaos(ueda):
    steps = fewest_steps(ueda)
    holds = all(value <= RULE for value in steps.values())
    regular = ueda.scheme.values[(ueda.exponent < 0).any("steps_per_period").values]
    reason = "at long steps the motion is regular" if len(regular) else "some schemes need more"
    return Finding(listed(steps, {"ueda": ueda}, ".0f", "none"), holds, when(not holds, reason))


def orders_of_means(ueda: xr.Dataset) -> dict[str, tuple[float, float]]:
    """Order with which the mean square of Ueda's oscillator converges, and its standard error, by scheme.

    The exact mean square is that of the Runge-Kutta method at the finest step. The order is a weighted fit over the
    steps from which on the motion is chaotic, where the mean differs by more than two standard errors; NaN for fewer
    than three such steps.
    """
    exact = ueda.sel(scheme="rk4").isel(steps_per_period=-1)
    difference = abs(ueda.mean_square - exact.mean_square)
    error = (ueda.mean_square_uncertainty**2 + exact.mean_square_uncertainty**2) ** 0.5
    known = _onwards(ueda.exponent > 0) & (difference > 2 * error)
    orders = {}
    for name in ueda.scheme.values:
        at = known.sel(scheme=name)
        steps = ueda.steps_per_period.values[at.values]
        values, errors = (one.sel(scheme=name).values[at.values] for one in (difference, error))
        orders[name] = (np.nan, np.nan)
        if len(steps) > 2:
            fit, covariance = np.polyfit(np.log(steps), np.log(values), 1, w=values / errors, cov="unscaled")
            orders[name] = (-fit[0], float(np.sqrt(covariance[0, 0])))
    return orders


@claim(
    "structures",
    "Statistics of a chaotic motion converge with the order of the scheme, although its orbits are lost.",
    "order of the mean square of Ueda's oscillator, with its standard error",
    whose=STUDY,
    requires={"ueda.schemes": ["rk4", *FAITHFUL]},
)
def statistics_converge(ueda):
    orders = {name: orders_of_means(ueda)[name] for name in FAITHFUL}
    titles = dict(zip(ueda.scheme.values, ueda.scheme_title.values, strict=True))
    ours = "; ".join(
        f"{titles[name]}: " + (f"{order:.1f} ± {error:.1f}" if np.isfinite(order) else "none")
        for name, (order, error) in orders.items()
    )
    holds = all(abs(order - 2) < max(NEARLY_TWO, 2 * error) for order, error in orders.values())
    return Finding(ours, holds, when(not holds, "steps with regular motion break the convergence"))
