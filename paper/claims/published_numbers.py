"""Claims on problems whose solution is published or exact."""

import numpy as np
import xarray as xr

from paper.claims.ledger import PRACTICE, Finding, by_name, claim, when
from paper.terms import GREATLY, REASONABLE, ROUND_OFF
from paper.wording import number
from study.sizes import fewest

#: Small parameter ε of van der Pol's oscillator, its shortest time scale.
FASTEST = 1e-6
#: Largest relative error of the displacement at the end of an orbit that counts as closed.
CLOSED = 0.01


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
    error = bar.end_error.sel(scheme="central_difference")
    steps = bar.steps[error.fillna(np.inf).argmin("refinement")].item()
    holds = float(error.min()) <= ROUND_OFF
    reason = when(not holds, "a wave crosses one element in none of the steps that were tried")
    return Finding(f"{number(error.min().item(), '.0g')} at {steps}", holds, reason)


def steps_of_orbit(published_numbers: xr.Dataset) -> dict[str, dict[str, float]]:
    """Fewest equal and controlled steps from which on all runs close Arenstorf's orbit, by scheme; NaN without them."""
    orbit = published_numbers.sel(problem="arenstorf")
    equal = fewest(orbit.end_error, orbit.steps, CLOSED, "refinement")
    controlled = fewest(orbit.controlled_end_error, orbit.controlled_steps, CLOSED, "tolerance")
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
    runs = published_numbers.sel(problem="van_der_pol")
    runs = runs.isel(scheme=np.flatnonzero(runs.explicit.values == 0))
    return by_name(runs.duration / fewest(runs.end_error, runs.steps, REASONABLE / 100, "refinement") / FASTEST)


@claim(
    "structures",
    "The step of an implicit scheme can far exceed the shortest time scale of every stiff problem.",
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
