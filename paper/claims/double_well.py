"""Claims of section 4 on the double well at a large step: Figure 4."""

import numpy as np

from paper.claims.comparisons import claim_period
from paper.claims.ledger import Finding, by_name, claim, when
from paper.terms import APART, AT_REST, DAMPED, EXPLICIT, IRREGULAR, REASONABLE, ROUND_OFF
from paper.wording import listed, number, title
from study.words import span

#: Initial energy above rest, (E₀ − E_rest)/|E₀|, for S₁ = −0.5, S₂ = −1 and u₀ = 0.5.
_HEIGHT = (7 / 128 - 1 / 8) / (-7 / 128)

#: Options that the configuration must have for the runs from neighbouring starts.
_NEIGHBOURS = {"sensitivity.problem": "double_well", "sensitivity.perturbation": 1e-10}

claim_period("4", "double_well", 1, "The period of this oscillator is equal to 7·3")


@claim(
    "4",
    "A step of 2.5 in the double well is about a third of its period.",
    "Δt/T",
    "1/3",
    words="Δt = 2·5 (≈T/3)",
    portrait="phase_portrait/double_well",
    reference="reference/double_well",
)
def step_is_a_third(portrait, reference):
    ratio = (portrait.step_size / reference.period).item()
    return Finding(f"{ratio:.3f}", round(ratio, 1) == 0.3)


@claim(
    "4",
    "At this step average acceleration becomes chaotic.",
    f"steps until two runs that start 10⁻¹⁰ to 2·10⁻⁹ apart are {APART:g} apart, from 40 starts above and below",
    words="the solution by the average acceleration method becomes chaotic",
    requires=_NEIGHBOURS,
)
def average_acceleration_is_chaotic(sensitivity):
    parted = sensitivity.parted_at_step.sel(scheme="average_acceleration").drop_sel(start=0)
    return Finding(span(parted, ".0f") if parted.min() > 0 else "never", bool(parted.min() > 0))


@claim(
    "4",
    "Average acceleration jumps irregularly between u = 1 and u = −1.",
    "changes of the well in 1,000 steps from neighbouring starts; number of different stays between them in one run",
    words="the numerical results jump irregularly between the system’s two static equilibria",
    portrait="phase_portrait/double_well",
    requires=_NEIGHBOURS,
)
def jumps_between_wells(portrait, sensitivity):
    u = portrait.u.sel(scheme="average_acceleration").values
    jumps = np.flatnonzero(np.diff(np.sign(u)) != 0)
    stays = len(set(np.diff(jumps)))
    changes = sensitivity.changes_of_sign.sel(scheme="average_acceleration")
    return Finding(f"{span(changes, '.0f')}; {stays}", stays > IRREGULAR)


@claim(
    "4",
    "The static equilibria of the double well are u = 1 and u = −1.",
    "largest distance of the damped schemes from ±1 at the end",
    words="two static equilibria u = 1 and u = −1",
    portrait="phase_portrait/double_well",
)
def rest_is_at_one(portrait):
    end = portrait.u.sel(scheme=DAMPED).isel(t=-1)
    worst = abs(abs(end) - 1).max().item()
    return Finding(number(worst, ".0e"), worst < ROUND_OFF)


@claim(
    "4",
    "For the two explicit schemes the normal Newton-Raphson method finds no converged solution at this step.",
    "kind of failure and step at which it occurred",
    words="cannot be obtained with the normal Newton–Raphson method when Δt = 2·5 is used",
    portrait="phase_portrait/double_well",
)
def explicit_schemes_fail(portrait):
    portrait = portrait.sel(scheme=EXPLICIT)
    meanings = portrait.status.attrs["flag_meanings"].split()
    ended = {name: meanings[int(portrait.status.sel(scheme=name))] for name in EXPLICIT}
    at_step = by_name(portrait.failed_at_step)
    endings = [f"{title(n, portrait)}: {ended[n].replace('_', ' ')} at step {at_step[n]:g}" for n in EXPLICIT]
    overflow = "because the displacement overflows: an explicit step does not use the Newton-Raphson method"
    reason = when(set(ended.values()) == {"not_finite"}, f"the solution is lost {overflow}")
    return Finding("; ".join(endings), bool((portrait.status != 0).all()), reason)


@claim(
    "4",
    "The results of the four damped schemes bear no resemblance to the exact solution.",
    "range of u over the last tenth of the time (exact: 0.82)",
    words="the results bear no resemblance to the exact solution",
    portrait="phase_portrait/double_well",
)
def no_resemblance(portrait):
    u = portrait.u.sel(scheme=DAMPED)
    late = u.isel(t=slice(-(u.sizes["t"] // 10), None))
    width = by_name(late.max("t") - late.min("t"))
    return Finding(listed(width, portrait, ".0e"), max(width.values()) < AT_REST)


@claim(
    "4",
    "High numerical damping causes the results of Figure 4 (c) to (f).",
    "part of the energy above rest that each scheme loses by the end, in percent; required: no gain of energy",
    words="when large time steps are used the numerical damping in these four schemes is so high",
    portrait="phase_portrait/double_well",
)
def damping_is_the_cause(portrait):
    error = 100 * portrait.energy_error
    damped = error.sel(scheme=DAMPED)
    lost = by_name(-damped.isel(t=-1) / _HEIGHT)
    gained = damped.max().item()
    undamped = abs(error.sel(scheme="average_acceleration")).max().item()
    undamped_words = f"average acceleration, which has no damping, has an energy error of up to {undamped:.0f} %"
    holds = min(lost.values()) > 100 - REASONABLE and gained < REASONABLE
    reason = when(undamped > REASONABLE, f"the step size is a cause as well: {undamped_words}")
    return Finding(listed(lost, portrait, ".0f"), holds, reason)
