"""Claims of those who published schemes since 1993, decided by runs and by the growth of a long first step."""

import numpy as np
import xarray as xr

from paper.claims.ledger import PRACTICE, STUDY, Finding, claim, most, when
from paper.claims.terms import ALMOST, GREATLY, ROUND_OFF, SECOND_ORDER, SIGNIFICANTLY, THIRD_ORDER
from paper.claims.wording import listed, number
from paper.tables.order_under_reality import LOST

_REALITY = "order_under_reality.schemes"
#: Least order found of a scheme of fourth order.
_FOURTH_ORDER = 3.5


def _stiffening(later_schemes: xr.Dataset, scheme: str) -> Finding:
    ratios = later_schemes.largest_stiffening.sel(with_model=scheme)
    ours = "; ".join(
        f"ωΔt = {step:g}: {number(float(ratios.sel(omega_step=step)), '.3g')}" for step in ratios.omega_step
    )
    bound, excess = bool(ratios.min() < GREATLY), float(((ratios - 1) * ratios.omega_step**2).median())
    reason = when(bound, f"the tangent may exceed the model by {number(excess)} M/Δt² only")
    return Finding(ours, not bound, reason)


def _claim_of_model(title: str):
    return claim(
        "schemes",
        f"{title} is unconditionally stable for structures that are not linear too.",
        "largest tangent, over the stiffness of the model, up to which a step is stable",
        whose=PRACTICE,
    )


@_claim_of_model("CR")
def cr_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "chen_ricles")


@_claim_of_model("Chang's method")
def chang_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "chang")


@_claim_of_model("KR-α")
def kr_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "kr_alpha")


def _orders(order_under_reality: xr.Dataset, scheme: str, circumstances: list[str], quantities: list[str]) -> float:
    """The least observed order."""
    orders = order_under_reality.observed_order
    return float(orders.sel(scheme=scheme, circumstance=circumstances, quantity=quantities).min(skipna=False))


_SMOOTH, _MOTION = ["plain", "damping", "load"], ["displacement", "velocity"]


@claim(
    "schemes",
    "MKR-α is of second order.",
    "least order of displacement and velocity, and order of the principal roots",
    whose="Kolay and Ricles (2019), abstract",
    requires={_REALITY: ["mkr_alpha"], "spectral.schemes": ["mkr_alpha"]},
)
def order_of_mkr(order_under_reality, spectral):
    order = _orders(order_under_reality, "mkr_alpha", _SMOOTH, _MOTION)
    of_roots = spectral.linear_order.sel(scheme="mkr_alpha").min().item()
    reason = when(order < SECOND_ORDER, "its velocity lags by half a step, which the roots do not show")
    return Finding(f"{number(order)}; {number(of_roots)}", order > SECOND_ORDER, reason)


@claim(
    "schemes",
    "The overshoot of MKR-α grows with the same power of the step as that of KR-α.",
    "largest power of ωΔt with which displacement or velocity of a long first step grow",
    whose=STUDY,
    requires={"spectral.schemes": ["kr_alpha", "mkr_alpha"], "spectral.damping_ratios": [0.0]},
)
def same_power_of_overshoot(spectral):
    powers = {name: _power(spectral, name) for name in ("kr_alpha", "mkr_alpha")}
    holds = abs(powers["mkr_alpha"] - powers["kr_alpha"]) < 0.5
    return Finding(listed(powers, {"spectral": spectral}, ".0f"), holds)


def _power(spectral: xr.Dataset, scheme: str) -> float:
    """The largest power of ωΔt with which a long first step grows without damping."""
    free = spectral.sel(damping_ratio=0, scheme=scheme)
    return max(float(free[f"growth_{one}_from_{start}"]) for one in "uv" for start in "uv")


@claim(
    "schemes",
    "OALTS does not overshoot, which the generalized-α method does.",
    "largest power of ωΔt with which displacement or velocity of a long first step grow",
    whose=STUDY,
    requires={"spectral.schemes": ["oalts", "generalized_alpha"], "spectral.damping_ratios": [0.0]},
)
def no_overshoot_of_two_steps(spectral):
    powers = {name: _power(spectral, name) for name in ("oalts", "generalized_alpha")}
    holds = powers["oalts"] < 0.5 < powers["generalized_alpha"]
    return Finding(listed(powers, {"spectral": spectral}, ".0f"), holds)


@claim(
    "schemes",
    "Of the explicit methods with a model of the structure, Chang's does not overshoot.",
    "largest power of ωΔt with which displacement or velocity of a long first step grow",
    whose=STUDY,
    requires={"spectral.schemes": ["chang", "chen_ricles", "kr_alpha"], "spectral.damping_ratios": [0.0]},
)
def overshoot_with_a_model(spectral):
    powers = {name: _power(spectral, name) for name in ("chang", "chen_ricles", "kr_alpha")}
    holds = powers["chang"] < 0.5 < min(powers["chen_ricles"], powers["kr_alpha"])
    return Finding(listed(powers, {"spectral": spectral}, ".0f"), holds)


@claim(
    "schemes",
    "WAT2 is of third order with two forces, with damping and load.",
    "least order of displacement and velocity; of the acceleration",
    whose="Wang et al. (2025)",
    requires={_REALITY: ["wat2"]},
)
def third_order_in_motion(order_under_reality):
    motion, acceleration = (
        _orders(order_under_reality, "wat2", _SMOOTH, quantities) for quantities in (_MOTION, ["acceleration"])
    )
    reason = when(acceleration < THIRD_ORDER, "the acceleration that it carries is of second order")
    return Finding(f"{number(motion)}; {number(acceleration)}", motion > THIRD_ORDER, reason)


@claim(
    "schemes",
    "ESDIRK methods do not lose their order in forced vibration.",
    "least order of the method of fourth order under a load; on a moving support that a stiff spring holds",
    whose="Li et al. (2023), abstract",
    requires={_REALITY: ["esdirk4"]},
)
def no_reduction_under_a_load(order_under_reality):
    supports = [name for name in order_under_reality.circumstance.values if name.startswith("support_")]
    everything = [*_MOTION, "acceleration"]
    load = _orders(order_under_reality, "esdirk4", ["load"], everything)
    support = _orders(order_under_reality, "esdirk4", supports, everything)
    reason = when(not support > _FOURTH_ORDER, "a stiff support lowers it")
    return Finding(f"{number(load)}; {number(support)}", load > _FOURTH_ORDER, reason)


@claim(
    "schemes",
    "The generalized-α method is of second order.",
    "least order of displacement and velocity; of the acceleration that it carries",
    whose="Chung and Hulbert (1993)",
    requires={_REALITY: ["generalized_alpha"]},
)
def second_order_of_generalized_alpha(order_under_reality):
    motion, acceleration = (
        _orders(order_under_reality, "generalized_alpha", _SMOOTH, quantities)
        for quantities in (_MOTION, ["acceleration"])
    )
    reason = when(acceleration < SECOND_ORDER, "its acceleration, which belongs to a time within the step, is of first")
    return Finding(f"{number(motion)}; {number(acceleration)}", motion > SECOND_ORDER, reason)


@claim(
    "schemes",
    "Newton's iteration must end near round-off for a scheme to have its order.",
    "most of the order of displacement that a scheme loses by iterations that end early",
    whose=PRACTICE,
    requires={_REALITY: ["average_acceleration"]},
)
def order_with_loose_tolerances(order_under_reality):
    orders = order_under_reality.observed_order.sel(quantity="displacement")
    loose = orders.isel(circumstance=orders.circumstance.str.startswith("tolerance_"))
    loss = (orders.sel(circumstance="plain") - loose).max().item()
    reason = when(loss < LOST, "the last correction leaves the square of its size")
    return Finding(number(max(0.0, loss), ".2f"), loss >= LOST, reason)


def _slope(error: xr.DataArray, steps: str) -> float:
    """Order by least squares over all numbers of steps."""
    return float(-np.polyfit(np.log(error[steps]), np.log(error), 1)[0])


@claim(
    "schemes",
    "With a scalar auxiliary variable BDF2 is bounded at every step without iteration.",
    "largest displacement in a thousand steps, over all steps; error over average acceleration's",
    whose="Shen et al. (2018)",
)
def bounded_by_an_auxiliary_variable(later_schemes):
    peak = later_schemes.auxiliary_peak.max(skipna=False).item()
    error = later_schemes.auxiliary_error
    ratio = (error.sel(auxiliary="auxiliary_variable") / error.sel(auxiliary="average_acceleration")).median().item()
    reason = when(ratio > ALMOST, "at equal steps its motion is farther from the exact one")
    return Finding(f"{number(peak, '.2g')}; {number(ratio)}", peak < GREATLY, reason)


@claim(
    "schemes",
    "BDF2 with a scalar auxiliary variable is of second order.",
    "order of the displacement on a hardening oscillator",
    whose="Shen et al. (2018)",
)
def order_with_an_auxiliary_variable(later_schemes):
    order = _slope(later_schemes.auxiliary_error.sel(auxiliary="auxiliary_variable"), "steps")
    return Finding(number(order), order > SECOND_ORDER)


def _uniformity(later_schemes: xr.Dataset, member: str) -> float:
    """Largest over smallest error / Δt², where the error is the largest over all ωΔt."""
    scaled = later_schemes.trigonometric_error.sel(member=member) * later_schemes.steps**2
    return (scaled.max() / scaled.min()).item()


_OVER_PHASES = "largest over smallest error/Δt² of steps, where the error is the largest over ωΔt of π/2 to 2π"


@claim(
    "schemes",
    "The error of Gautschi's method is of the size Δt², whatever ωΔt is.",
    _OVER_PHASES,
    whose=PRACTICE,
)
def uniform_error_of_gautschi(later_schemes):
    spread = _uniformity(later_schemes, "gautschi")
    reason = when(spread > SIGNIFICANTLY, "it takes the force at an unfiltered displacement, and some ωΔt err more")
    return Finding(number(spread), spread <= SIGNIFICANTLY, reason)


@claim(
    "schemes",
    "The error of the mollified impulse method is of the size Δt², whatever ωΔt is.",
    _OVER_PHASES,
    whose="García-Archilla et al. (1998)",
)
def uniform_error_of_mollified_impulse(later_schemes):
    spread = _uniformity(later_schemes, "garcia_archilla")
    return Finding(number(spread), spread <= SIGNIFICANTLY)


@claim(
    "schemes",
    "The impulse method errs more at some ωΔt, which mollifying cures.",
    _OVER_PHASES,
    whose="García-Archilla et al. (1998)",
)
def resonances_of_impulse(later_schemes):
    plain, mollified = (_uniformity(later_schemes, member) for member in ("deuflhard", "garcia_archilla"))
    return Finding(f"{number(plain)}; {number(mollified)}", plain > SIGNIFICANTLY >= mollified)


@claim(
    "schemes",
    "β₁/β₂-Bathe with β₂ = 2β₁ is better for waves than ρ∞-Bathe.",
    "error of the velocity along a bar, least over Courant numbers, over the error of ρ∞-Bathe",
    whose="Malakiyeh et al. (2019)",
)
def better_for_waves(later_schemes):
    least = later_schemes.wave_error.min("courant")
    ratio = (least.sel(wave_scheme="beta_bathe") / least.sel(wave_scheme="rho_bathe")).item()
    better = bool(least.sel(wave_scheme="central_difference") < least.sel(wave_scheme="beta_bathe"))
    reason = when(better, "central difference errs less at its best step")
    return Finding(number(ratio, ".2f"), ratio < 1, reason)


@claim(
    "schemes",
    "Noh and Bathe's explicit method is better for waves than central difference.",
    "error of the velocity along a bar, over the error of central difference with the same forces",
    whose="Noh and Bathe (2013)",
    requires={"later_schemes.courant": [0.5, 1.0]},
)
def better_for_waves_than_central_difference(later_schemes):
    error = later_schemes.wave_error
    ours, other = error.sel(wave_scheme="noh_bathe", courant=1.0), error.sel(wave_scheme="central_difference")
    ratio = (ours / other.sel(courant=0.5)).item()
    reason = when(other.min() < ours, "at its largest step central difference errs less")
    return Finding(number(ratio, ".2f"), ratio < 1, reason)


@claim(
    "schemes",
    "Blanes and Moan's method errs least of its order at equal cost.",
    "error of other methods of fourth order over its own, at equal forces; least median over numbers of forces",
    whose="Blanes and Moan (2002)",
)
def least_error_of_fourth_order(later_schemes):
    error, own = later_schemes.fourth_order_error, {"of_fourth_order": "blanes_moan4"}
    ratios = (error / error.sel(own)).drop_sel(own).median("forces")
    ratio, best = ratios.min().item(), "McLachlan's" if ratios.idxmin() == "mclachlan4" else "another"
    reason = when(ratio < 1, f"{best} method errs less on this oscillator")
    return Finding(number(ratio, ".2f"), ratio >= 1, reason)


@claim(
    "schemes",
    "Relaxation keeps the order.",
    "order of the motion by the two finest steps, least over springs",
    whose="Ranocha et al. (2020), abstract",
)
def order_with_relaxation(relaxation):
    fine = relaxation.motion_error.sel(variant="relaxed").isel(steps_per_period=slice(-2, None))
    order = min(_slope(fine.sel(problem=problem), "steps_per_period") for problem in fine.problem.values)
    return Finding(number(order), order > _FOURTH_ORDER)


@claim(
    "schemes",
    "Relaxation makes the motion more accurate.",
    "springs and steps with a smaller error, of all; error without over error with, in the median",
    whose="Ranocha and Ketcheson (2020), abstract",
)
def motion_with_relaxation(relaxation):
    error = relaxation.motion_error.stack(cell=["problem", "steps_per_period"])
    ratio = error.sel(variant="plain") / error.sel(variant="relaxed")
    cells = {str(place): bool(value > 1 + ROUND_OFF) for place, value in enumerate(ratio.values)}
    holds, exceptions = most(cells)
    ours = f"{len(cells) - len(exceptions)} of {len(cells)}; {number(ratio.median().item())}"
    return Finding(ours, holds, when(exceptions and holds, "not at all steps"))
