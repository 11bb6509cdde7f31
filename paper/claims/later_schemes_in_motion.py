"""Claims on later schemes, decided by runs, by the growth of motion at large ωΔt, or by stability."""

import numpy as np
import xarray as xr

from paper.claims.ledger import PRACTICE, STUDY, Finding, claim, most, when
from paper.measures.orders import LOST
from paper.terms import ALMOST, GREATLY, ROUND_OFF, SECOND_ORDER, SIGNIFICANTLY, THIRD_ORDER
from paper.wording import listed, number
from study.analysis.orders import observed_order
from study.words import span

_REALITY = "order_under_reality.schemes"
#: Smallest observed order that counts as fourth order.
_FOURTH_ORDER = 3.5


def excess_of_tangent(later_schemes: xr.Dataset, scheme: str) -> float:
    """Largest excess of the tangent over the model's stiffness with stable steps, in M/Δt²: its median over ωΔt."""
    ratios = later_schemes.largest_stiffening.sel(with_model=scheme)
    return float(((ratios - 1) * ratios.omega_step**2).median())


def _stiffening(later_schemes: xr.Dataset, scheme: str) -> Finding:
    ratios = later_schemes.largest_stiffening.sel(with_model=scheme)
    ours = "; ".join(f"ωΔt = {step:g}: {number(ratio, '.3g')}" for step, ratio in ratios.to_series().items())
    bound, excess = bool(ratios.min() < GREATLY), excess_of_tangent(later_schemes, scheme)
    reason = when(bound, f"the tangent may exceed the stiffness of the model only by {number(excess)} M/Δt²")
    return Finding(ours, not bound, reason)


def _claim_of_model(title: str):
    return claim(
        "schemes",
        f"{title} is unconditionally stable for non-linear structures too.",
        "largest ratio of the tangent to the stiffness of the model at which a step is stable",
        whose=PRACTICE,
    )


@_claim_of_model("CR")
def cr_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "chen_ricles")


@_claim_of_model("Chang's method")
def chang_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "chang")


@_claim_of_model("KR-α with ρ∞ = 1")
def kr_on_stiffening(later_schemes):
    return _stiffening(later_schemes, "kr_alpha")


def _orders(order_under_reality: xr.Dataset, scheme: str, circumstances: list[str], quantities: list[str]) -> float:
    """Smallest observed order."""
    orders = order_under_reality.observed_order
    return float(orders.sel(scheme=scheme, circumstance=circumstances, quantity=quantities).min(skipna=False))


_SMOOTH, _MOTION = ["plain", "damping", "load"], ["displacement", "velocity"]


def _order_of_lagging(later_schemes: xr.Dataset, scheme: str) -> Finding:
    error = later_schemes.lag_error.sel(lagging=scheme).isel(many_steps=[-2, -1])
    first, lagged = (-np.log2(error).diff("many_steps")).squeeze().values
    reason = when(first < SECOND_ORDER, "its velocity lags by γΔt, and the start must lag too")
    return Finding(f"{number(first)}; {number(lagged)}", lagged > SECOND_ORDER, reason)


def _claim_of_order(title: str, whose: str):
    return claim(
        "schemes",
        f"{title} is of second order.",
        "order of the displacement at the end of a run from the initial velocity; from the velocity a time γΔt earlier",
        whose=whose,
    )


@_claim_of_order("CR", PRACTICE)
def order_of_cr(later_schemes):
    return _order_of_lagging(later_schemes, "chen_ricles")


@_claim_of_order("KR-α", PRACTICE)
def order_of_kr(later_schemes):
    return _order_of_lagging(later_schemes, "kr_alpha")


@_claim_of_order("MKR-α", "Kolay and Ricles (2019), abstract")
def order_of_mkr(later_schemes):
    return _order_of_lagging(later_schemes, "mkr_alpha")


@claim(
    "schemes",
    "The overshoot of MKR-α grows with the same power of the step as that of KR-α.",
    "largest power of ωΔt with which displacement or velocity grows in a long first step",
    whose=STUDY,
    requires={"spectral.schemes": ["kr_alpha", "mkr_alpha"], "spectral.damping_ratios": [0.0]},
)
def same_power_of_overshoot(spectral):
    powers = {name: _power(spectral, name) for name in ("kr_alpha", "mkr_alpha")}
    holds = abs(powers["mkr_alpha"] - powers["kr_alpha"]) < 0.5
    return Finding(listed(powers, {"spectral": spectral}, ".0f"), holds)


def _power(spectral: xr.Dataset, scheme: str) -> float:
    """Largest power of ωΔt with which an undamped displacement or velocity grows in a first step with large ωΔt."""
    free = spectral.sel(damping_ratio=0, scheme=scheme)
    return max(float(free[f"growth_{variable}_from_{start}"]) for variable in "uv" for start in "uv")


@claim(
    "schemes",
    "Unlike the generalized-α method, OALTS does not overshoot.",
    "largest power of ωΔt with which displacement or velocity grows in a long first step",
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
    "largest power of ωΔt with which displacement or velocity grows in a long first step",
    whose=STUDY,
    requires={"spectral.schemes": ["chang", "chen_ricles", "kr_alpha"], "spectral.damping_ratios": [0.0]},
)
def overshoot_with_a_model(spectral):
    powers = {name: _power(spectral, name) for name in ("chang", "chen_ricles", "kr_alpha")}
    holds = powers["chang"] < 0.5 < min(powers["chen_ricles"], powers["kr_alpha"])
    return Finding(listed(powers, {"spectral": spectral}, ".0f"), holds)


@claim(
    "schemes",
    "WAT2, with two forces per step, is of third order with damping and load.",
    "smallest order of displacement and velocity; smallest order of the acceleration",
    whose="Wang et al. (2025)",
    requires={_REALITY: ["wat2"]},
)
def third_order_in_motion(order_under_reality):
    motion, acceleration = (
        _orders(order_under_reality, "wat2", _SMOOTH, quantities) for quantities in (_MOTION, ["acceleration"])
    )
    reason = when(acceleration < THIRD_ORDER, "the acceleration that a step passes on is of second order")
    return Finding(f"{number(motion)}; {number(acceleration)}", motion > THIRD_ORDER, reason)


@claim(
    "schemes",
    "ESDIRK methods do not lose their order in forced vibration.",
    "smallest order of the fourth-order method under a load; with a moving support on a stiff spring",
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
    "smallest order of displacement and velocity; smallest order of the acceleration that a step passes on",
    whose="Chung and Hulbert (1993)",
    requires={_REALITY: ["generalized_alpha"]},
)
def second_order_of_generalized_alpha(order_under_reality):
    motion, acceleration = (
        _orders(order_under_reality, "generalized_alpha", _SMOOTH, quantities)
        for quantities in (_MOTION, ["acceleration"])
    )
    reason = when(acceleration < SECOND_ORDER, "its acceleration, at a time within the step, is of first order")
    return Finding(f"{number(motion)}; {number(acceleration)}", motion > SECOND_ORDER, reason)


@claim(
    "schemes",
    "Newton's iteration must converge to round-off for a scheme to retain its order.",
    "largest loss of the order of displacement by iterations that end early",
    whose=PRACTICE,
    requires={_REALITY: ["average_acceleration"]},
)
def order_with_loose_tolerances(order_under_reality):
    orders = order_under_reality.observed_order.sel(quantity="displacement")
    loose = orders.isel(circumstance=orders.circumstance.str.startswith("tolerance_"))
    loss = (orders.sel(circumstance="plain") - loose).max().item()
    reason = when(loss < LOST, "the remaining error is of the size of the square of the last correction")
    return Finding(number(max(0.0, loss), ".2f"), loss >= LOST, reason)


@claim(
    "schemes",
    "With a scalar auxiliary variable BDF2 is bounded at every step without iteration.",
    "largest displacement in a thousand steps, over all step sizes; ratio of the error to that of average acceleration",
    whose="Shen et al. (2018)",
)
def bounded_by_an_auxiliary_variable(later_schemes):
    peak = later_schemes.auxiliary_peak.max(skipna=False).item()
    error = later_schemes.auxiliary_error
    ratio = error.sel(auxiliary="auxiliary_variable") / error.sel(auxiliary="average_acceleration")
    reason = when(ratio.max() > ALMOST, "at equal steps its error is larger")
    return Finding(f"{number(peak, '.2g')}; {span(ratio)}", peak < GREATLY, reason)


@claim(
    "schemes",
    "BDF2 with a scalar auxiliary variable is of second order.",
    "order of the displacement on a hardening oscillator",
    whose="Shen et al. (2018)",
)
def order_with_an_auxiliary_variable(later_schemes):
    error = later_schemes.auxiliary_error.sel(auxiliary="auxiliary_variable")
    order = observed_order(error.steps.values, error.values)
    return Finding(number(order), order > SECOND_ORDER)


def _uniformity(later_schemes: xr.Dataset, member: str) -> float:
    """Largest value of error/Δt² divided by the smallest. Each step size has one error, the largest of all ωΔt."""
    scaled = later_schemes.trigonometric_end_error.sel(member=member) * later_schemes.steps**2
    return (scaled.max() / scaled.min()).item()


_OVER_PHASES = "ratio over step sizes of largest to smallest error/Δt²; each is the largest for ωΔt from π/2 to 2π"


@claim("schemes", "The error of Gautschi's method is of order Δt² for every ωΔt.", _OVER_PHASES, whose=PRACTICE)
def uniform_error_of_gautschi(later_schemes):
    spread = _uniformity(later_schemes, "gautschi")
    reason = when(spread > SIGNIFICANTLY, "its force is at an unfiltered displacement; some ωΔt have larger errors")
    return Finding(number(spread), spread <= SIGNIFICANTLY, reason)


@claim(
    "schemes",
    "The error of the mollified impulse method is of order Δt² for every ωΔt.",
    _OVER_PHASES,
    whose="García-Archilla et al. (1998)",
)
def uniform_error_of_mollified_impulse(later_schemes):
    spread = _uniformity(later_schemes, "garcia_archilla")
    return Finding(number(spread), spread <= SIGNIFICANTLY)


@claim(
    "schemes",
    "The impulse method has larger errors at some ωΔt, and the mollified impulse method does not.",
    _OVER_PHASES,
    whose="García-Archilla et al. (1998)",
)
def resonances_of_impulse(later_schemes):
    plain, mollified = (_uniformity(later_schemes, member) for member in ("deuflhard", "garcia_archilla"))
    return Finding(f"{number(plain)}; {number(mollified)}", plain > SIGNIFICANTLY >= mollified)


@claim(
    "schemes",
    "β₁/β₂-Bathe with β₂ = 2β₁ is better for waves than ρ∞-Bathe.",
    "ratio to the error of ρ∞-Bathe of the velocity along a bar, each the smallest over Courant numbers",
    whose="Malakiyeh et al. (2019)",
)
def better_for_waves(later_schemes):
    least = later_schemes.wave_error.min("courant")
    ratio = (least.sel(wave_scheme="beta_bathe") / least.sel(wave_scheme="rho_bathe")).item()
    better = bool(least.sel(wave_scheme="central_difference") < least.sel(wave_scheme="beta_bathe"))
    reason = when(better, "central difference has a smaller error at its best step")
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
    ours, central = error.sel(wave_scheme="noh_bathe", courant=1.0), error.sel(wave_scheme="central_difference")
    ratio = (ours / central.sel(courant=0.5)).item()
    reason = when(central.min() < ours, "central difference has a smaller error at its largest step")
    return Finding(number(ratio, ".2f"), ratio < 1, reason)


@claim(
    "schemes",
    "Blanes and Moan's method has the smallest error of its order at equal cost.",
    "ratios, over numbers of forces, of the error of the best other method of fourth order to its own",
    whose="Blanes and Moan (2002)",
)
def least_error_of_fourth_order(later_schemes):
    error, reference = later_schemes.fourth_order_error, {"fourth_order_scheme": "blanes_moan4"}
    ratios = (error / error.sel(reference)).drop_sel(reference)
    medians = ratios.median("force_evaluations")
    name = medians.idxmin().item()
    holds = medians.min().item() >= 1
    best = "McLachlan's" if name == "mclachlan4" else "another"
    reason = when(not holds, f"{best} method has a smaller error on this oscillator")
    return Finding(span(ratios.sel(fourth_order_scheme=name)), holds, reason)


@claim(
    "schemes",
    "Relaxation keeps the order.",
    "order of the motion from the two finest steps, smallest over springs",
    whose="Ranocha et al. (2020), abstract",
)
def order_with_relaxation(relaxation):
    fine = relaxation.return_error.sel(variant="relaxed").isel(steps_per_period=slice(-2, None))
    steps = fine.steps_per_period.values
    order = min(observed_order(steps, fine.sel(problem=problem).values, least=2) for problem in fine.problem.values)
    return Finding(number(order), order > _FOURTH_ORDER)


@claim(
    "schemes",
    "Relaxation makes the motion more accurate.",
    "ratio of the error without relaxation to that with it, over springs and steps",
    whose="Ranocha and Ketcheson (2020), abstract",
)
def motion_with_relaxation(relaxation):
    error = relaxation.return_error.stack(cell=["problem", "steps_per_period"])
    ratio = error.sel(variant="plain") / error.sel(variant="relaxed")
    cells = {str(place): bool(value > 1 + ROUND_OFF) for place, value in enumerate(ratio.values)}
    holds, exceptions = most(cells)
    return Finding(span(ratio, ".3g"), holds, when(exceptions and holds, "not at all steps"))
