"""Claims of sections 1 and 2."""

import numpy as np

from paper.claims.ledger import Data, Finding, by_name, claim, listed
from paper.rounding import same, twice

PERIODS = {"hardening": 0.15, "softening": 1.14, "softening_large": 1.8, "double_well": 7.3}


def _of_references(data: Data, variable: str) -> dict[str, float]:
    return {name: data[f"reference/{name}"][variable].item() for name in PERIODS}


@claim(
    "1",
    "The exact solutions keep their total energy.",
    "largest relative change of the energy along the reference",
    reads=["reference/hardening", "reference/softening", "reference/softening_large", "reference/double_well"],
)
def energy_is_kept(data):
    worst = max(_of_references(data, "energy_drift").values())
    return Finding(f"{worst:.0e}", worst < 1e-12)


@claim(
    "1",
    "Equations (2) and (3) have periodic solutions.",
    "largest distance from the start after one exact period",
    reads=["reference/hardening", "reference/softening", "reference/softening_large", "reference/double_well"],
)
def solutions_are_periodic(data):
    distances = []
    for name in PERIODS:
        reference = data[f"reference/{name}"]
        distances.append(abs(reference.u[-1] - reference.u[0]).item() / abs(reference.u[0]).item())
    return Finding(f"{max(distances):.0e}", max(distances) < 1e-12)


@claim(
    "1",
    "The period can be found analytically or by integration with very small steps.",
    "relative error of the period by CVODE, diffrax and heyoka at their tightest tolerance",
    reads=["reference_agreement"],
    asks={"references.problems": list(PERIODS), "agreement.tolerances": [1e-15]},
)
def period_by_every_route(data):
    best = by_name(data["reference_agreement"].period_error.min("tolerance").max("problem"))
    return Finding(listed(best, ".0e"), max(best.values()) < 1e-12)


@claim(
    "1",
    "Even on a simple unforced oscillator the Newmark method may predict chaos.",
    "growth of a perturbation of 1e-10 under average acceleration in the double well",
    reads=["sensitivity"],
    asks={"sensitivity.problem": "double_well"},
)
def newmark_may_be_chaotic(data):
    separation = data["sensitivity"].separation.sel(scheme="average_acceleration")
    return Finding(f"to {separation.max().item():.2g}", separation.max().item() > 0.1)


@claim(
    "2.1",
    "Newmark's method with β = 0 and γ = ½ is the method of central difference.",
    "largest residual of (uₙ₊₁ − 2uₙ + uₙ₋₁)/Δt² + p(uₙ) = 0, relative to the largest force",
    reads=["phase_portrait/hardening"],
)
def newmark_beta_zero_is_central_difference(data):
    portrait = data["phase_portrait/hardening"].sel(scheme="central_difference")
    u = portrait.u.values
    force = 100 * u * (1 + 10 * u**2)  # eq. (2) with the paper's constants
    residual = np.diff(u, 2) / portrait.dt.item() ** 2 + force[1:-1]
    worst = np.abs(residual).max() / np.abs(force).max()
    return Finding(f"{worst:.0e}", worst < 1e-10)


@claim(
    "2.3",
    "Houbolt's method is started as in Argyris and Mlejnek (the start is not named).",
    "error on the hardening spring at T/20 by start",
    "97.3 %",
    reads=["houbolt_start"],
    asks={"houbolt_start.problems": ["hardening"], "houbolt_start.steps_per_period": [20]},
)
def start_of_houbolt(data):
    at = data["houbolt_start"].max_energy_error.sel(problem="hardening", steps_per_period=20)
    values = by_name(at)
    matching = at.start.values[same(twice(at), 97.3).values].tolist()
    ours = {name.replace("_", " "): value for name, value in values.items()}
    return Finding(
        f"{listed(ours, '.3f')} %",
        matching == ["linear_acceleration"],
        "only Houbolt's own fictitious points, which make the first step the linear acceleration method, "
        "give the printed digit, rounded twice as the other cells were",
    )
