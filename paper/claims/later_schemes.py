"""Claims of the authors of later schemes, decided on linear oscillators; a claim on relaxation is decided by runs."""

import numpy as np

from paper.claims.ledger import Finding, claim, when
from paper.terms import ALMOST, REASONABLE, ROUND_OFF, SECOND_ORDER, THIRD_ORDER
from paper.wording import listed, number


def _undamped(spectral, variable):
    return spectral[variable].sel(damping_ratio=0)


@claim(
    "schemes",
    "OALTS damps low frequencies half as much as the generalized-α method of equal ρ∞.",
    "algorithmic damping of OALTS at T/100 over the damping of generalized-α",
    whose="Zhang (2020)",
    requires={"spectral.schemes": ["oalts", "generalized_alpha"], "spectral.damping_ratios": [0.0]},
)
def half_the_damping(spectral):
    damping = _undamped(spectral, "algorithmic_damping").sel(step_size_over_period=0.01, method="nearest")
    part = (damping.sel(scheme="oalts") / damping.sel(scheme="generalized_alpha")).item()
    return Finding(number(part, ".2f"), 0.5 / ALMOST <= part <= 0.5 * ALMOST)


@claim(
    "schemes",
    "MKR-α overshoots less than KR-α.",
    "largest overshoot of the displacement over all step sizes, relative; period error at T/10 over KR-α's",
    whose="Kolay and Ricles (2019)",
    requires={"spectral.schemes": ["kr_alpha", "mkr_alpha"], "spectral.damping_ratios": [0.0]},
)
def less_overshoot(spectral):
    schemes = ["kr_alpha", "mkr_alpha"]
    overshoot = _undamped(spectral, "displacement_overshoot").max("step_size_over_period").sel(scheme=schemes)
    elongation = abs(_undamped(spectral, "period_elongation")).sel(step_size_over_period=0.1, method="nearest")
    price = (elongation.sel(scheme="mkr_alpha") / elongation.sel(scheme="kr_alpha")).item()
    largest = dict(zip(schemes, overshoot.values.tolist(), strict=True))
    reason = when(price > ALMOST, "its period error is larger")
    ours = f"{listed(largest, {'spectral': spectral}, '.2g')}; {number(price, '.2f')}"
    return Finding(ours, largest["mkr_alpha"] < largest["kr_alpha"], reason)


@claim(
    "schemes",
    "CR is explicit and unconditionally stable.",
    "largest stable ωΔt; largest overshoot of the displacement over all step sizes, relative",
    whose="Chen and Ricles (2008)",
    requires={"spectral.schemes": ["chen_ricles"], "spectral.damping_ratios": [0.0]},
)
def stable_with_a_model(spectral):
    limit = _undamped(spectral, "stability_limit").sel(scheme="chen_ricles").item()
    overshoot = _undamped(spectral, "displacement_overshoot").sel(scheme="chen_ricles").max().item()
    reason = when(overshoot > 1, "at large steps the displacement first grows to many times its initial value")
    return Finding(f"{number(limit)}; {number(overshoot, '.0f')}", np.isinf(limit), reason)


@claim(
    "schemes",
    "Chang's method is explicit, unconditionally stable and of second order.",
    "largest stable ωΔt; order of the principal roots, smallest over damping ratios",
    whose="Chang (2002)",
    requires={"spectral.schemes": ["chang"], "spectral.damping_ratios": [0.0]},
)
def second_order_with_a_model(spectral):
    limit = _undamped(spectral, "stability_limit").sel(scheme="chang").item()
    order = spectral.linear_order.sel(scheme="chang").min().item()
    return Finding(f"{number(limit)}; {number(order)}", np.isinf(limit) and order > SECOND_ORDER)


@claim(
    "schemes",
    "ICL is of second order with damping, with one force and no matrix except the mass matrix.",
    "order of its principal roots, smallest over damping ratios; largest stable ωΔt without and with damping",
    whose="Li et al. (2021)",
    requires={"spectral.schemes": ["icl"], "spectral.damping_ratios": [0.0]},
)
def second_order_with_one_force(spectral):
    at = spectral.sel(scheme="icl").sortby("damping_ratio")
    order, limits = at.linear_order.min().item(), at.stability_limit.values
    reason = when(limits[-1] < limits[0] / ALMOST, "damping lowers its limit of stability")
    ours = f"{number(order)}; {number(limits[0], '.2f')}, {number(limits[-1], '.2f')}"
    return Finding(ours, order > SECOND_ORDER, reason)


@claim(
    "schemes",
    "WAT2 is of third order with damping.",
    "order of its principal roots without and with damping",
    whose="Wang et al. (2025)",
    requires={"spectral.schemes": ["wat2"]},
)
def third_order_with_damping(spectral):
    order = spectral.linear_order.sel(scheme="wat2").sortby("damping_ratio")
    return Finding(" and ".join(map(number, order.values)), bool((order > THIRD_ORDER).all()))


@claim(
    "schemes",
    "ESDIRK methods of s sub-steps combine order s, unconditional stability and controlled dissipation.",
    "order of their principal roots, smallest over damping ratios; largest stable ωΔt; spectral radius at infinite "
    "frequency",
    whose="Li et al. (2023), abstract",
    requires={"spectral.schemes": ["esdirk3", "esdirk4"], "spectral.damping_ratios": [0.0]},
)
def order_stability_and_dissipation_at_once(spectral):
    words, holds = [], True
    for s, name in ((3, "esdirk3"), (4, "esdirk4")):
        order = spectral.linear_order.sel(scheme=name).min().item()
        limit, radius = (
            _undamped(spectral, variable).sel(scheme=name).item()
            for variable in ("stability_limit", "infinite_frequency_radius")
        )
        words.append(f"s = {s}: {number(order)}, {number(limit)}, {number(radius, '.2f')}")
        holds = holds and order > s - 0.5 and bool(np.isinf(limit)) and radius < 1
    return Finding("; ".join(words), holds)


@claim(
    "schemes",
    "Mixed Padé methods of M terms are of order 2M − 1, with a prescribed spectral radius at infinite frequency.",
    "order with damping and load for M = 1, 2, ...; largest deviation of the radius at ωΔt = 10⁶ from its prescription",
    whose="Song et al. (2023)",
)
def order_and_dissipation_of_mixed_pade(later_schemes):
    before, last = (later_schemes.pade_error.isel(long_steps=place) for place in (-2, -1))
    finer = later_schemes.long_steps.values[-1] / later_schemes.long_steps.values[-2]
    orders = np.log(before.values / last.values) / np.log(finer)
    off = abs(later_schemes.pade_radius - later_schemes.attrs["rho_inf"]).max().item()
    holds = bool((orders > 2 * later_schemes.terms.values - 1.5).all()) and off < ROUND_OFF
    return Finding(f"{', '.join(map(number, orders.tolist()))}; {number(off, '.0e')}", holds)


@claim(
    "schemes",
    "With relaxation, Runge-Kutta conserves the energy to round-off.",
    "largest error of the energy at the steps of the paper, in percent; largest error of the motion at the end",
    whose="Ranocha and Ketcheson (2020), abstract",
)
def energy_by_relaxation(relaxation):
    relaxed = relaxation.sel(variant="relaxed")
    energy, motion = 100 * float(relaxed.max_energy_error.max()), 100 * float(relaxed.return_error.max())
    reason = when(motion > REASONABLE, "at large steps the motion is inaccurate")
    return Finding(f"{number(energy, '.0e')}; {number(motion, '.0f')}", energy < 100 * ROUND_OFF, reason)
