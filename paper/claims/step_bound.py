"""Claims on the bound of the energy error by the modified energy, decided by our runs."""

import numpy as np
import xarray as xr

from paper.claims.ledger import Finding, claim, when
from paper.wording import listed
from study.words import number

SCHEMES = ["central_difference", "average_acceleration"]
#: Largest relative difference of measured and predicted error at which a prediction is confirmed, and share of the runs
#: that counts as most of them.
CONFIRMED, MOST_RUNS = 0.1, 0.95
#: Springs whose tangent is nowhere negative, and the largest ωΔt at which the bound is checked. As in the texts, a step
#: has two decimals, rounded down.
CONVEX, LARGEST_STEP = ["hardening", "softening"], 0.17
#: Largest excess of a ratio that is printed as one.
ROUNDED = 0.005


def confirmed(bound: xr.Dataset) -> xr.DataArray:
    """Whether a measured error is close to the predicted one, (scheme, motion, quantity)."""
    return abs(bound.measured_error / (bound.coefficient * bound.omega_step**2) - 1) < CONFIRMED


def exceptions(bound: xr.Dataset, missed: xr.DataArray) -> list[str]:
    """Potential and initial displacement of some motions."""
    motions = (bound.isel(motion=place) for place in np.flatnonzero(missed.values))
    return [f"“{motion.potential_title.item()}” from {number(motion.u0.item())}" for motion in motions]


@claim(
    "stability",
    "The modified energy of central difference and average acceleration predicts the energy error of a step.",
    f"runs in several potentials whose energy error is within {100 * CONFIRMED:g} % of the predicted one; largest "
    "measured over predicted error",
    bound="stability/step_bound",
)
def modified_energy_predicts(bound):
    bound = bound.sel(scheme=SCHEMES, quantity="energy")
    close = confirmed(bound)
    ratio = (bound.measured_error / (bound.coefficient * bound.omega_step**2)).max().item()
    missed = exceptions(bound, ~close.all("scheme"))
    holds = float(close.mean()) >= MOST_RUNS
    return Finding(
        f"{int(close.sum())} of {close.size}; {ratio:.2f}", holds, when(missed, f"except for {', '.join(missed)}")
    )


def over_convex(bound: xr.Dataset, rule: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Energy error over its bound on springs whose tangent is nowhere negative, at steps up to ``LARGEST_STEP``.

    The ratio is infinite for a failed run. The second result says whether the tangent changes within the step by so
    little that the bound holds.
    """
    rule = rule.sel(problem=CONVEX, scheme=SCHEMES)
    rule = rule.isel(omega_step=np.flatnonzero(np.floor(100 * rule.omega_step) / 100 <= LARGEST_STEP))
    ratio = (rule.max_energy_error / (bound.convex_coefficient * rule.omega_step**2)).fillna(np.inf)
    return ratio, (rule.omega_step <= rule.described_up_to).broadcast_like(ratio)


@claim(
    "stability",
    "Where the tangent is nowhere negative, the energy error is at most (ωΔt)²/4 by central difference and (ωΔt)²/6 by "
    "average acceleration.",
    f"largest ratio of the error to this bound, ωΔt up to {LARGEST_STEP:g}, all amplitudes of the maps at which the "
    "tangent changes within a step by at most half of its largest size",
    requires={"step_rule.schemes": SCHEMES},
    bound="stability/step_bound",
    rule="stability/step_rule",
)
def tangent_bounds_the_energy(bound, rule):
    ratio, described = over_convex(bound, rule)
    ratio = ratio.where(described)
    most = ratio.max(["problem", "amplitude", "omega_step"]).sel(scheme=SCHEMES).values.tolist()
    beyond = int((ratio > 1 + CONFIRMED).sum())
    reason = (
        f"terms of higher order exceed it by more than {100 * CONFIRMED:g} % in {beyond} of {int(described.sum())} runs"
        if beyond
        else f"terms of higher order in the step add up to {100 * CONFIRMED:g} %"
    )
    ours = listed(dict(zip(SCHEMES, most, strict=True)), {"rule": rule}, ".2f")
    return Finding(ours, not beyond, when(max(most) > 1 + ROUNDED, reason))
