"""Claims of section 3.2: the softening spring."""

from paper.claims.comparisons import at_step, claim_period, claim_printed_error, lost_energy
from paper.claims.ledger import Finding, by_name, claim, errors, most, when
from paper.published import PROBLEMS
from paper.terms import ALIKE, FAITHFUL, FAR_OFF, REASONABLE
from paper.wording import joined, listed

claim_period("3.2", "softening", 2, "The period of this oscillator is equal to 1·14")


@claim(
    "3.2",
    "On the softening spring the schemes behave as on the hardening one.",
    "rank correlation of the errors of the schemes on both springs, smallest over the step sizes",
    words="the behaviour of the integration schemes is similar to that for the previous hardening spring",
)
def springs_agree(energy_error):
    # ranks of the errors of each spring: one column per step size, one row per scheme
    ranks = [errors(energy_error, name).to_series().unstack("steps_per_period").rank() for name in PROBLEMS]
    alike = {at_step(steps): value for steps, value in ranks[0].corrwith(ranks[1]).items()}
    holds, exceptions = most({step: value > ALIKE for step, value in alike.items()})
    least = min(alike, key=alike.__getitem__)
    reason = when(exceptions, f"not at {joined(exceptions, energy_error)}")
    return Finding(f"{alike[least]:.2f}, at {least}", holds, reason)


@claim(
    "3.2",
    "On the softening spring Newmark (γ = 0.6), Houbolt and Wilson damp strongly too.",
    "signed energy error at the end, softening at T/20",
    words="Strong numerical damping is again observed",
    portrait="phase_portrait/softening",
)
def damping_on_softening(portrait):
    lost = lost_energy(portrait)
    return Finding(f"{listed(lost, portrait)} %", max(lost.values()) < -FAR_OFF)


@claim(
    "3.2",
    "Average acceleration and central difference are fairly accurate at T/20.",
    "errors at T/20, softening",
    "4.7 %, 7.3 %",
    words="give fairly accurate results when the time step Δt is as large as T/20",
)
def faithful_at_a_twentieth(energy_error):
    at = by_name(errors(energy_error, "softening").sel(steps_per_period=20, scheme=FAITHFUL))
    return Finding(f"{listed(at, energy_error)} %", max(at.values()) <= REASONABLE)


claim_printed_error(
    "3.2",
    "Newmark (γ = 0.6) is extremely inaccurate even at T/1000.",
    "softening",
    1000,
    "newmark_dissipative",
    32.4,
    "even with a time step as small as T/1000 it gives an error as high as 32·4%",
)
