"""Claims about structures, which the paper did not compute; some of the claims extend its verdicts to structures."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from paper.claims.ledger import PRACTICE, XIE_EXTENDED, Finding, by_name, claim, most, when
from paper.data import TURNING
from paper.published import SCHEMES
from paper.requirements import samples_of_history
from paper.terms import DISSIPATIVE, EXPLICIT, FAITHFUL, GREATLY, REASONABLE, RULE
from paper.wording import joined, listed

#: Structures with modes that are too fast for most of the steps to resolve.
STIFF = ["stiff_soft", "elastic_pendulum", "fpu_chain", "spinning_truss"]
#: Algebraically stable methods, which are BN-stable by a theorem of Burrage and Butcher.
BN_STABLE = ["implicit_midpoint", "gauss4"]
#: Minimum number of samples of a history after its start. The last half then has four samples, which can alternate.
SAMPLES_OF_SAWTOOTH = 6


def balanced(runs: xr.Dataset, problems: list[str] | None = None) -> xr.DataArray:
    """Whether each run completed and kept the balance of energies, on the given problems or by default on all."""
    if problems is not None:
        runs = runs.sel(problem=[name for name in problems if name in runs.problem.values])
    return (runs.status == 0) & (100 * runs.max_energy_imbalance <= REASONABLE)


def fails_to(runs: xr.DataArray, along: Sequence[str] = ("problem", "steps_per_period")) -> xr.DataArray:
    """Most steps in the time scale at which a run fails, by scheme; NaN if no run fails."""
    return runs.steps_per_period.where(~runs).max(along)


def sawtooth(velocity: xr.DataArray) -> np.ndarray:
    """Amplitude of the part of a velocity that changes sign at every sample, in the last half of a history.

    It is the highest difference of the n + 1 samples, over 2ⁿ. A smooth velocity of the circular frequency ω adds at
    most sinⁿ(ωΔt/2) of its amplitude.
    """
    late = velocity.isel(t=slice(velocity.sizes["t"] // 2, None)).transpose(..., "t").values
    order = late.shape[-1] - 1
    return np.abs(np.diff(late, order))[..., 0] / 2**order


def _share(runs: xr.DataArray, schemes: list[str]) -> dict[str, float]:
    """Percentage of the runs for which ``runs`` is true, by scheme."""
    return by_name(100 * runs.sel(scheme=schemes).mean(["problem", "steps_per_period"]))


@claim(
    "structures",
    "Average acceleration and central difference are the best of the seven schemes of 1996.",
    f"share of the runs on structures that keep the balance of energies within {REASONABLE:g} %, in percent",
    whose=XIE_EXTENDED,
    requires={"structures.schemes": SCHEMES},
)
def faithful_on_structures(structures):
    share = _share(balanced(structures), SCHEMES)
    best = sorted(share, key=share.__getitem__, reverse=True)[:2]
    holding = [name for name in FAITHFUL if name in best]
    reason = f"of these two, the best two of the seven include {joined(holding, structures)}"
    if "central_difference" not in holding:
        reason += "; an explicit scheme fails where the step does not resolve the stiffest mode"
    ours = f"{listed(share, structures, '.0f')}, of {structures.status.sel(scheme=SCHEMES[0]).size} runs each"
    return Finding(ours, len(holding) == 2, "" if len(holding) == 2 else reason)


@claim(
    "structures",
    "Newmark (γ = 0.6), Houbolt and Wilson damp structures too strongly.",
    "largest error of the balance of energies on the Fermi-Pasta-Ulam chain at the finest step, in percent",
    whose=XIE_EXTENDED,
    requires={"structures.lengths.problem": ["fpu_chain"], "structures.schemes": DISSIPATIVE},
)
def damping_on_the_chain(structures):
    chain = 100 * structures.max_energy_imbalance.sel(problem="fpu_chain", scheme=DISSIPATIVE)
    lost = by_name(chain.isel(steps_per_period=-1))
    strong = [name for name, error in lost.items() if error > REASONABLE]
    weak = [name for name in DISSIPATIVE if name not in strong]
    reason = when(weak, f"at the finest step not {joined(weak, structures)}")
    return Finding(listed(lost, structures), bool(strong), reason)


@claim(
    "structures",
    "Average acceleration oscillates spuriously where a mode is too stiff for the step.",
    "alternating part of the velocity of the mass on the stiff spring late in the run",
    whose="Bathe and Noh",
    requires={
        "structure_history.stiff_soft.problem": "stiff_soft",
        "structure_history.stiff_soft.schemes": ["average_acceleration", "bathe"],
        "structure_history.stiff_soft": samples_of_history(SAMPLES_OF_SAWTOOTH),
    },
    history="structure_history/stiff_soft",
)
def spurious_oscillation(history):
    parts = dict(zip(history.scheme.values.tolist(), sawtooth(history.v.isel(component=0)).tolist(), strict=True))
    return Finding(
        listed(parts, history, ".2g"),
        parts["average_acceleration"] > GREATLY * parts["bathe"],
        "the structure itself oscillates as much from rest, at a frequency that no step here resolves; the scheme "
        "preserves that energy at a wrong frequency",
    )


@claim(
    "structures",
    "Where stiff modes rotate, the trapezoidal and the midpoint rule fail, and the energy-momentum method does not.",
    "most steps tried in a time scale, each twice the one before, at which a run on such structures fails or violates "
    f"the balance of energies by more than {REASONABLE:g} %",
    requires={
        "structures.lengths.problem": ["elastic_pendulum"],
        "structures.schemes": ["average_acceleration", "implicit_midpoint", "energy_momentum"],
    },
)
def conserving_on_stiff_structures(structures):
    runs = balanced(structures, TURNING)
    names = ["average_acceleration", "implicit_midpoint", "energy_momentum"]
    most_steps_per_period = fails_to(runs).sel(scheme=names)
    holds = most_steps_per_period.isnull().values.tolist() == [False, False, True]
    return Finding(listed(by_name(most_steps_per_period), structures, ".0f", "none"), holds)


@claim(
    "structures",
    "A BN-stable method is unconditionally stable in the non-linear range.",
    "most steps tried in a time scale, each twice the one before, at which a run of these on rotating structures "
    f"fails or violates the balance of energies by more than {REASONABLE:g} %",
    whose="Burrage and Butcher (1979)",
    requires={
        "structures.lengths.problem": ["elastic_pendulum"],
        "structures.schemes": BN_STABLE,
    },
)
def stable_by_contraction(structures):
    most_steps_per_period = fails_to(balanced(structures, TURNING)).sel(scheme=BN_STABLE)
    holds = bool(most_steps_per_period.isnull().all())
    reason = when(
        not holds,
        "BN-stability bounds the distance of two motions under contractive forces only, and these are not contractive",
    )
    return Finding(listed(by_name(most_steps_per_period), structures, ".0f", "none"), holds, reason)


@claim(
    "structures",
    "Explicit schemes with a stability limit are useless on structures with a stiff mode, however slow the motion is.",
    "most steps in a time scale at which a run of an explicit scheme fails or violates the balance of energies by more "
    f"than {REASONABLE:g} %, by structure; required: more than {RULE}",
    whose=PRACTICE,
    requires={
        "structures.lengths.problem": ["stiff_soft", "elastic_pendulum", "fpu_chain"],
        "structures.schemes": EXPLICIT,
    },
)
def explicit_on_stiff_structures(structures):
    runs = balanced(structures, STIFF)
    most_steps_per_period = fails_to(runs.sel(scheme=EXPLICIT), ["steps_per_period"])
    saved = [name for name in runs.problem.values.tolist() if runs.sel(problem=name, scheme=EXPLICIT).any()]
    reason = when(saved, f"at the finest steps they resolve the stiff modes of the {joined(saved, structures)}")
    least = by_name(most_steps_per_period.min("scheme", skipna=False))
    return Finding(listed(least, structures, ".0f", "none"), bool((most_steps_per_period > RULE).all()), reason)


@claim(
    "structures",
    "Δt < T/20 is reasonable for average acceleration on structures.",
    f"error of the displacement at {RULE} steps in the time scale of the motion, by structure, in percent",
    whose=XIE_EXTENDED,
    requires={"structures.schemes": ["average_acceleration"], "structures.steps_per_period": [RULE]},
)
def a_twentieth_on_structures(structures):
    runs = structures.sel(scheme="average_acceleration", steps_per_period=RULE)
    error = by_name(100 * runs.sampled_displacement_error)
    holds, _ = most({name: value <= REASONABLE for name, value in error.items()})
    good = [name for name, value in error.items() if value <= REASONABLE]
    reason = when(len(good) < len(error), f"only on {joined(good, structures)}")
    return Finding(listed(error, structures, ".0f"), holds, reason)
