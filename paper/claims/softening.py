"""Claims of section 3.2: the softening spring."""

from paper.claims.comparisons import at_step, claim_period, claim_printed_error, lost_energy
from paper.claims.ledger import Finding, by_name, claim, errors, most
from paper.claims.terms import ALIKE, FAITHFUL, FAR_OFF, REASONABLE
from paper.claims.wording import joined, listed
from paper.published import PROBLEMS

claim_period("3.2", "softening", 2, "The period of this oscillator is equal to 1·14")


@claim(
    "3.2",
    "On the softening spring the schemes behave as on the hardening one.",
    "rank correlation of the errors of the schemes on both springs, smallest over the step sizes",
    words="the behaviour of the integration schemes is similar to that for the previous hardening spring",
    reads=["energy_error"],
)
def springs_agree(data):
    # the schemes of one step size along each column
    ranks = [errors(data, name).to_series().unstack("steps_per_period").rank() for name in PROBLEMS]
    alike = {at_step(steps): value for steps, value in ranks[0].corrwith(ranks[1]).items()}
    holds, exceptions = most({step: value > ALIKE for step, value in alike.items()})
    least = min(alike, key=alike.__getitem__)
    reason = f"not at {joined(exceptions, data)}" if exceptions else ""
    return Finding(f"{alike[least]:.2f}, at {least}", holds, reason)


@claim(
    "3.2",
    "On the softening spring Newmark (γ = 0.6), Houbolt and Wilson damp strongly too.",
    "signed energy error at the end, softening at T/20",
    words="Strong numerical damping is again observed",
    reads=["phase_portrait/softening"],
)
def damping_on_softening(data):
    lost = lost_energy(data, "softening")
    return Finding(f"{listed(lost, data)} %", max(lost.values()) < -FAR_OFF)


@claim(
    "3.2",
    "Average acceleration and central difference are fairly accurate at T/20.",
    "errors at T/20, softening",
    "4.7 %, 7.3 %",
    words="give fairly accurate results when the time step Δt is as large as T/20",
    reads=["energy_error"],
)
def faithful_at_a_twentieth(data):
    at = by_name(errors(data, "softening").sel(steps_per_period=20, scheme=FAITHFUL))
    return Finding(f"{listed(at, data)} %", max(at.values()) <= REASONABLE)


claim_printed_error(
    "3.2",
    "Newmark (γ = 0.6) is extremely inaccurate even at T/1000.",
    "softening",
    1000,
    "newmark_dissipative",
    32.4,
    "even with a time step as small as T/1000 it gives an error as high as 32·4%",
)
