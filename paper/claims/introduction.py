"""Claims of sections 1 and 2."""

import numpy as np

from paper.claims.ledger import Finding, by_name, claim
from paper.published import same, twice
from paper.terms import APART, ROUND_OFF
from paper.wording import joined, listed, number
from study.words import span

PERIODS = {"hardening": 0.15, "softening": 1.14, "softening_large": 1.8, "double_well": 7.3}
REFERENCES = [f"reference/{name}" for name in PERIODS]


@claim(
    "1",
    "The exact solutions keep their total energy.",
    "largest relative change of the energy along the reference",
    words="conservative systems which maintain a constant total energy E in their exact solutions",
    references=REFERENCES,
)
def energy_is_kept(references):
    worst = max(reference.energy_drift.item() for reference in references)
    return Finding(number(worst, ".0e"), worst < ROUND_OFF)


@claim(
    "1",
    "Equations (2) and (3) have periodic solutions.",
    "largest distance from the start after one exact period, relative to u₀",
    words="have solutions representing periodic oscillations",
    references=REFERENCES,
)
def solutions_are_periodic(references):
    worst = max((abs(reference.u[-1] - reference.u[0]) / abs(reference.u[0])).item() for reference in references)
    return Finding(number(worst, ".0e"), worst < ROUND_OFF)


@claim(
    "1",
    "The period can be found analytically or by integration with very small steps.",
    "largest relative error of the period by CVODE, diffrax and heyoka, each at its tightest tolerance",
    words="obtained numerically by using time integration with very small time steps",
    requires={"references.problems": list(PERIODS), "agreement.tolerances": [1e-15]},
)
def period_by_every_route(reference_agreement):
    worst = reference_agreement.period_error.min("tolerance").max().item()
    return Finding(number(worst, ".0e"), worst < ROUND_OFF)


@claim(
    "1",
    "Even on a simple unforced oscillator the Newmark method may predict chaos.",
    "steps until two runs of average acceleration in the double well that start 10⁻¹⁰ to 2·10⁻⁹ apart are "
    f"{APART:g} apart, from 40 starts above and below",
    words="may lead to chaotic predictions",
    requires={"sensitivity.problem": "double_well"},
)
def newmark_may_be_chaotic(sensitivity):
    parted = sensitivity.parted_at_step.sel(scheme="average_acceleration").drop_sel(start=0)
    return Finding(span(parted, ".0f") if parted.min() > 0 else "never", bool(parted.min() > 0))


@claim(
    "2.1",
    "The Newmark method with β = 0 and γ = ½ is the method of central difference.",
    "largest residual of (uₙ₊₁ − 2uₙ + uₙ₋₁)/Δt² + p(uₙ) = 0, relative to the largest force",
    words="is equivalent to the method of central difference",
    portrait="phase_portrait/hardening",
)
def newmark_beta_zero_is_central_difference(portrait):
    portrait = portrait.sel(scheme="central_difference")
    u = portrait.u.values
    force = 100 * u * (1 + 10 * u**2)  # eq. (2) with the paper's constants
    residual = np.diff(u, 2) / portrait.step_size.item() ** 2 + force[1:-1]
    worst = np.abs(residual).max() / np.abs(force).max()
    return Finding(number(worst, ".0e"), worst < ROUND_OFF)


@claim(
    "2.3",
    "The Houbolt method is started as in Argyris and Mlejnek, whose scheme the paper does not give.",
    "error on the hardening spring at T/20 by start",
    "97.3 %",
    words="The initialization scheme as described in reference [6] is used",
    requires={"houbolt_start.problems": ["hardening"], "houbolt_start.steps_per_period": [20]},
)
def start_of_houbolt(houbolt_start):
    at = 100 * houbolt_start.max_energy_error.sel(problem="hardening", steps_per_period=20)
    matching = at.start.values[same(twice(at), 97.3).values].tolist()
    values = {name.replace("taylor", "Taylor"): value for name, value in by_name(at).items()}
    holds = matching == ["linear_acceleration"]
    return Finding(
        f"{listed(values, {}, '.3f')} %",
        holds,
        "only Houbolt's own fictitious points, which make the first step the linear acceleration method, give the "
        "printed digits, if they are rounded twice like the other cells"
        if holds
        else f"starts that give the printed digits: {joined(matching, {})}",
    )


@claim(
    "2.3",
    "The Houbolt method needs more memory than the other schemes, and a starting procedure.",
    "vectors of the size of u that a step passes to the next; spread of the error at T/20, hardening, over four starts",
    words="Apart from the extra memory needed for storing the displacements at several steps, the Houbolt method "
    "requires an initialization",
    requires={"houbolt_start.problems": ["hardening"], "houbolt_start.steps_per_period": [20]},
)
def houbolt_needs_memory(spectral, houbolt_start):
    memory = by_name(spectral.memory)
    at = 100 * houbolt_start.max_energy_error.sel(problem="hardening", steps_per_period=20)
    spread = (at.max() - at.min()).item()
    others = [value for name, value in memory.items() if name != "houbolt"]
    return Finding(f"{listed(memory, spectral, '.0f')}; {spread:.3f} %", memory["houbolt"] > max(others) and spread > 0)
