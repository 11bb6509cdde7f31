"""Claims of section 4: smaller steps with larger errors, unconditional stability, and the α-method."""

import numpy as np

from paper.claims.comparisons import claim_period, claim_printed_error
from paper.claims.ledger import Finding, by_name, claim, errors, when
from paper.published import printed_energy_errors
from paper.requirements import RESONANCE, rising, spans
from paper.terms import (
    ALMOST,
    EXPLICIT,
    GROWN,
    MOST,
    NOT_UNCOMMON,
    REASONABLE,
    RESONANT,
    ROUND_OFF,
    UNCONDITIONAL,
    UNSTABLE,
)
from paper.wording import joined, listed, number
from study.words import span

#: Problems of the two springs: the hardening spring, and the softening spring with both initial displacements.
_TWO_SPRINGS = ["hardening", "softening", "softening_large"]


@claim(
    "4",
    "On the softening spring at T/20 Runge-Kutta is the most accurate of the seven.",
    "errors at T/20, softening",
    words="it appears that the Runge–Kutta method is the most accurate integration scheme of the seven schemes",
    requires=RESONANCE,
)
def runge_kutta_is_best(energy_error, energy_drift):
    at = errors(energy_error, "softening").sel(steps_per_period=20)
    resonance = energy_drift.steps_per_oscillation.sel(steps_per_period=20, method="nearest").item()
    held = abs(resonance - np.round(resonance)) < RESONANT
    reason = when(held, f"an accident: a resonance holds the orbit at {resonance:.2f} steps per oscillation")
    return Finding(f"{listed(by_name(at), energy_error)} %", at.idxmin("scheme").item() == "rk4", reason)


claim_printed_error(
    "4",
    "The error of Runge-Kutta drops to 1.0 % at T/20.",
    "softening",
    20,
    "rk4",
    1.0,
    "the maximum error in the total energy drops to 1·0%",
)
claim_printed_error(
    "4",
    "With the smaller step T/25 the error of Runge-Kutta rises to 8.3 %.",
    "softening",
    25,
    "rk4",
    8.3,
    "is “increased” to 8·3%",
)


@claim(
    "4",
    "It is not uncommon that a smaller step gives a less accurate solution of a non-linear system.",
    f"share of pairs of neighbouring step sizes whose smaller step has an error more than {ALMOST:g} times as large, "
    "all schemes and springs from T/100 to T",
    words="Such behaviour of having a less accurate solution with a smaller time step is not uncommon",
    requires={"large_steps.step_size_over_period": rising},
)
def smaller_may_be_worse(large_steps):
    error = large_steps.max_energy_error.transpose(..., "step_size_over_period").values
    smaller, larger = error[..., :-1], error[..., 1:]
    pairs = np.isfinite(smaller) & np.isfinite(larger)
    worse = (smaller[pairs] > ALMOST * larger[pairs]).sum()
    share = worse / pairs.sum()
    printed = printed_energy_errors().transpose(..., "steps_per_period").values
    rises = (printed[..., 1:] > ALMOST * printed[..., :-1]).sum()
    cells = printed[..., 1:].size
    reason = when(rises <= NOT_UNCOMMON * cells, f"in Tables 1 and 2 it happens in {rises} of {cells} pairs")
    return Finding(f"{100 * share:.0f} % of {pairs.sum()}", bool(share > NOT_UNCOMMON), reason)


@claim(
    "4",
    "With average acceleration a smaller step may turn a stable solution into an unstable one (Xie and Steven).",
    f"softening spring from u₀ = 10: a larger step with an error up to {REASONABLE:g} %, an unstable smaller step",
    words="a smaller time step may even change a stable solution to an unstable one",
    requires={
        "large_steps.problems": ["softening_large"],
        "large_steps.step_size_over_period": rising,
    },
)
def smaller_may_be_unstable(large_steps):
    error = 100 * large_steps.max_energy_error.sel(problem="softening_large", scheme="average_acceleration")
    error = error.dropna("step_size_over_period")
    unstable = error.step_size_over_period.values[error.values > UNSTABLE]
    stable = error.step_size_over_period.values[error.values <= REASONABLE]
    pairs = [(small, large) for small in unstable for large in stable if small < large]
    if not pairs:
        return Finding("no such pair of step sizes", False, "no smaller step was less stable on the grid")
    small, large = min(pairs)
    at = by_name(error)
    return Finding(f"{at[large]:.1f} % at Δt/T = {large:g}, {at[small]:.0f} % at {small:g}", True)


@claim(
    "4",
    "Five of the schemes are unconditionally stable for linear systems.",
    "largest spectral radius minus one",
    "0",
    words="five are unconditionally stable for linear systems",
    requires={"spectral.damping_ratios": [0.0]},
)
def five_are_unconditionally_stable(spectral):
    radius = spectral.spectral_radius.sel(damping_ratio=0)
    excess = radius.sel(scheme=UNCONDITIONAL).max().item() - 1
    # a radius up to 1 + 1e-6 counts as one: a double root on the unit circle is accurate to half of the digits
    limited = bool((radius.sel(scheme=EXPLICIT).max("step_size_over_period") > 1 + 1e-6).all())
    return Finding(number(excess, ".0e"), excess < ROUND_OFF and limited)


@claim(
    "4",
    "On non-linear systems unconditional stability is lost.",
    "schemes of the five that more than double their energy in the second half of a run on the two springs",
    words="such unconditional stability is no longer valid",
    requires={"large_steps.problems": _TWO_SPRINGS},
)
def stability_is_lost(large_steps):
    large = large_steps.sel(problem=_TWO_SPRINGS, scheme=UNCONDITIONAL)
    gains = (100 * large.late_energy_gain > GROWN).any(["problem", "step_size_over_period"])
    overshoots = (100 * large.max_energy_error > UNSTABLE).any(["problem", "step_size_over_period"]) & ~gains
    grow, lose, none = (
        large.scheme.values[mask.values].tolist() for mask in (gains, overshoots, ~(gains | overshoots))
    )
    reasons = [f"{joined(lose, large_steps)} overshoot and then lose their energy"] * bool(lose)
    reasons += [f"{joined(none, large_steps)} never double their energy"] * bool(none)
    return Finding(joined(grow, large_steps) if grow else "none", len(grow) > 0, "; ".join(reasons))


claim_period("4", "softening_large", 1, "The period of this oscillator is equal to 1·8")


@claim(
    "4",
    "The α-method is unstable on the softening spring from u₀ = 10 at T/8.",
    "ratio of the largest to the initial energy of the α-method, at steps and from starts close to those of 1996",
    words="was obtained when Δt = T/8 was used for the α-method",
    requires={
        "step_window.problem": "softening_large",
        "step_window.schemes": ["hht_alpha_1996"],
        "step_window.step_size_over_period": spans(1 / 8),
    },
)
def alpha_is_unstable(step_window):
    gain = step_window.largest_gain.sel(scheme="hht_alpha_1996")
    share = (100 * gain > UNSTABLE).mean().item()
    reason = when(share < 1, f"the energy more than doubles in {100 * share:.0f} % of {gain.size:,} such runs")
    return Finding(span(1 + gain, ".1f"), share > MOST, reason)


@claim(
    "4",
    "The α-method has moderate numerical damping.",
    "1 − spectral radius at T/20; required: larger than for average acceleration, smaller than for all others",
    words="which has moderate numerical damping",
    requires={"spectral.damping_ratios": [0.0]},
)
def alpha_is_moderate(spectral):
    radius = spectral.spectral_radius.sel(scheme=UNCONDITIONAL, damping_ratio=0)
    damping = by_name(1 - radius.sel(step_size_over_period=0.05, method="nearest"))
    order = sorted(damping, key=damping.__getitem__)
    shown = {name: value if value > ROUND_OFF else 0.0 for name, value in damping.items()}
    return Finding(listed(shown, spectral, ".1e"), order[:2] == ["average_acceleration", "hht_alpha_1996"])
