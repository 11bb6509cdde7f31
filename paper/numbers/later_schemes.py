"""Numbers of the text: schemes since 1996, from the ledger and from the table of decisions."""

import pandas as pd
import xarray as xr

from paper.claims.later_schemes_in_motion import excess_of_tangent
from paper.claims.ledger import Verdict
from paper.products import numbers
from study.runs.needs import DECIDED
from study.words import at_most

#: Schemes with a model of the structure in their coefficients. Their claims of stability are judged together.
WITH_MODEL = ("chen_ricles", "chang", "kr_alpha")
#: Facts of the text. A fact is true if all its statements have its verdict in the ledger.
STATED = {
    "model_is_a_bound": (
        Verdict.NOT_REPRODUCED,
        "CR is unconditionally stable for non-linear structures too.",
        "Chang's method is unconditionally stable for non-linear structures too.",
        "KR-α with ρ∞ = 1 is unconditionally stable for non-linear structures too.",
    ),
    "model_overshoots": (
        Verdict.REPRODUCED,
        "Of the explicit methods with a model of the structure, Chang's does not overshoot.",
    ),
    "mkr_overshoots_less": (Verdict.QUALIFIED, "MKR-α overshoots less than KR-α."),
    "velocities_lag": (
        Verdict.QUALIFIED,
        "CR is of second order.",
        "KR-α is of second order.",
        "MKR-α is of second order.",
    ),
    "wat2_is_of_third_order": (
        Verdict.QUALIFIED,
        "WAT2, with two forces per step, is of third order with damping and load.",
    ),
    "esdirk_loses_order": (Verdict.QUALIFIED, "ESDIRK methods do not lose their order in forced vibration."),
    "blanes_moan_is_not_best": (
        Verdict.NOT_REPRODUCED,
        "Blanes and Moan's method has the smallest error of its order at equal cost.",
    ),
    "oalts_damps_less": (
        Verdict.REPRODUCED,
        "OALTS damps low frequencies half as much as the generalized-α method of equal ρ∞.",
        "Unlike the generalized-α method, OALTS does not overshoot.",
    ),
    "relaxation_keeps_energy": (
        Verdict.QUALIFIED,
        "With relaxation, Runge-Kutta conserves the energy to round-off.",
    ),
    "auxiliary_is_bounded": (
        Verdict.QUALIFIED,
        "With a scalar auxiliary variable BDF2 is bounded at every step without iteration.",
    ),
    "gautschi_is_not_uniform": (
        Verdict.NOT_REPRODUCED,
        "The error of Gautschi's method is of order Δt² for every ωΔt.",
    ),
    "mollified_is_uniform": (
        Verdict.REPRODUCED,
        "The error of the mollified impulse method is of order Δt² for every ωΔt.",
    ),
    "waves_by_central_difference": (
        Verdict.QUALIFIED,
        "β₁/β₂-Bathe with β₂ = 2β₁ is better for waves than ρ∞-Bathe.",
        "Noh and Bathe's explicit method is better for waves than central difference.",
    ),
}
#: Values that the text takes from the ledger. Each is a part of our result for the last statement of a fact; the number
#: is the index of the part.
VALUES = {
    "overshoot_kr": ("mkr_overshoots_less", 0),
    "overshoot_mkr": ("mkr_overshoots_less", 1),
    "period_error_mkr": ("mkr_overshoots_less", 2),
    "order_mkr": ("velocities_lag", 0),
    "order_mkr_lagged": ("velocities_lag", 1),
    "order_wat2": ("wat2_is_of_third_order", 0),
    "order_wat2_acceleration": ("wat2_is_of_third_order", 1),
    "order_esdirk_load": ("esdirk_loses_order", 0),
    "order_esdirk_support": ("esdirk_loses_order", 1),
    "blanes_moan_ratio": ("blanes_moan_is_not_best", 0),
    "relaxation_energy": ("relaxation_keeps_energy", 0),
    "relaxation_motion": ("relaxation_keeps_energy", 1),
    "auxiliary_ratio": ("auxiliary_is_bounded", 1),
    "gautschi_spread": ("gautschi_is_not_uniform", 0),
    "mollified_spread": ("mollified_is_uniform", 0),
}
#: Year after which a scheme is a later one.
YEAR = 1996


def _later(decisions: xr.Dataset, needs: xr.Dataset) -> dict[str, str]:
    """Share of later schemes among the schemes that the table of decisions names, by kind, such as "3 of 20"."""
    years = needs.scheme_source.to_series().str.extract(r"\((\d{4})", expand=False).astype(int)
    counts = {}
    tabulated = decisions.sel(filter="all", quantity=[name for name in DECIDED if name in decisions.quantity])
    for kind in decisions.kind.values:
        chosen = [name for name in tabulated.scheme.sel(kind=kind).values.ravel() if name]
        counts[f"later_{kind}"] = f"{(years[chosen] > YEAR).sum()} of {len(chosen)}"
    return counts


@numbers(claims="claims.csv")
def later_scheme_numbers(
    claims: pd.DataFrame, decisions: xr.Dataset, needs: xr.Dataset, later_schemes: xr.Dataset
) -> dict:
    """Facts and values of the ledger, the bound on the tangent, and the share of later schemes among the choices."""
    ledger = claims.set_index("claim")
    facts = {
        name: bool((ledger.verdict[list(statements)] == verdict).all())
        for name, (verdict, *statements) in STATED.items()
    }
    values = {
        name: ledger.ours[STATED[fact][-1]].split("; ")[place].rpartition(": ")[2]
        for name, (fact, place) in VALUES.items()
    }
    excess = max(excess_of_tangent(later_schemes, scheme) for scheme in WITH_MODEL)
    dissipative = later_schemes.largest_stiffening.sel(with_model="kr_alpha_dissipative").min().item()
    return {
        **facts,
        **values,
        **_later(decisions, needs),
        "model_excess": at_most(excess, 2),
        "model_excess_dissipative": f"{100 * (dissipative - 1):.0f}",
    }
