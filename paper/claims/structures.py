"""Claims about structures, which the paper did not compute; most of them are its verdicts applied to them."""

import numpy as np
import xarray as xr

from paper.asks import samples_of_history
from paper.claims.ledger import PRACTICE, XIE_EXTENDED, Data, Finding, by_name, claim, most
from paper.claims.terms import DISSIPATIVE, EXPLICIT, FAITHFUL, GREATLY, MOST, REASONABLE, RULE
from paper.claims.wording import joined, listed
from paper.data import TURNING
from paper.published import SCHEMES

#: Structures with modes far too fast for the steps.
STIFF = ["stiff_soft", "elastic_pendulum", "fpu_chain", "spinning_truss"]
#: Samples that a history needs after its start: its last half then has three, the fewest that can alternate.
SAMPLES_OF_SAWTOOTH = 4


def kept(data: Data, problems: list[str] | None = None) -> xr.DataArray:
    """Whether a run ended with its balance of energies kept, over problem, scheme and steps_per_period.

    Given problems that were not computed are left out.
    """
    runs = data["structures"]
    if problems is not None:
        runs = runs.sel(problem=[name for name in problems if name in runs.problem.values])
    return (runs.status == 0) & (runs.max_energy_imbalance <= REASONABLE)


def sawtooth(velocity: xr.DataArray) -> np.ndarray:
    """Amplitude of the part of a velocity that changes its sign with every step, over the last half of a history."""
    late = velocity.isel(t=slice(velocity.sizes["t"] // 2, None)).values
    return np.abs(late[..., 2:] - 2 * late[..., 1:-1] + late[..., :-2]).max(axis=-1) / 4


def _share(runs: xr.DataArray, schemes: list[str]) -> dict[str, float]:
    """Share of the runs in percent, by scheme."""
    return by_name(100 * runs.sel(scheme=schemes).mean(["problem", "steps_per_period"]))


@claim(
    "structures",
    "Average acceleration and central difference are the best of the seven schemes of 1996.",
    f"share of the runs on structures that keep the balance of energies within {REASONABLE:g} %, in percent",
    whose=XIE_EXTENDED,
    reads=["structures"],
    asks={"structures.schemes": SCHEMES},
)
def faithful_on_structures(data):
    share = _share(kept(data), SCHEMES)
    best = sorted(share, key=share.__getitem__, reverse=True)[:2]
    holding = [name for name in FAITHFUL if name in best]
    reason = f"of the two, among the best two of the seven: {joined(holding, data)}"
    if "central_difference" not in holding:
        reason += "; an explicit scheme is of no use where modes are stiffer than the step resolves"
    return Finding(listed(share, data, ".0f"), len(holding) == 2, "" if len(holding) == 2 else reason)


@claim(
    "structures",
    "Newmark (γ = 0.6), Houbolt and Wilson damp structures too strongly.",
    "largest error of the balance of energies on the Fermi-Pasta-Ulam chain at the finest step, in percent",
    whose=XIE_EXTENDED,
    reads=["structures"],
    asks={"structures.lengths.problem": ["fpu_chain"], "structures.schemes": DISSIPATIVE},
)
def damping_on_the_chain(data):
    chain = data["structures"].max_energy_imbalance.sel(problem="fpu_chain", scheme=DISSIPATIVE)
    lost = by_name(chain.isel(steps_per_period=-1))
    return Finding(listed(lost, data), min(lost.values()) > REASONABLE)


@claim(
    "structures",
    "Average acceleration oscillates spuriously where a mode is too stiff for the step.",
    "alternating part of the velocity of the mass on the stiff spring late in the run",
    whose="Bathe and Noh",
    reads=["structure_history/stiff_soft"],
    asks={
        "structure_history.stiff_soft.problem": "stiff_soft",
        "structure_history.stiff_soft.schemes": ["average_acceleration", "bathe"],
        "structure_history.stiff_soft": samples_of_history("structure_history.stiff_soft", SAMPLES_OF_SAWTOOTH),
    },
)
def spurious_oscillation(data):
    history = data["structure_history/stiff_soft"]
    parts = dict(zip(history.scheme.values.tolist(), sawtooth(history.v.isel(component=0)).tolist(), strict=True))
    return Finding(
        listed(parts, data, ".3f"),
        parts["average_acceleration"] > GREATLY * parts["bathe"],
        "the structure itself oscillates as much from rest, at a frequency that no step here resolves; the scheme "
        "keeps that energy and shows it at the wrong frequency",
    )


@claim(
    "structures",
    "Where stiff modes rotate, the trapezoidal and the midpoint rule fail, and the energy-momentum method does not.",
    f"runs on such structures that fail or leave the balance of energies by more than {REASONABLE:g} %",
    reads=["structures"],
    asks={
        "structures.lengths.problem": ["elastic_pendulum"],
        "structures.schemes": ["average_acceleration", "implicit_midpoint", "energy_momentum"],
    },
)
def conserving_on_stiff_structures(data):
    runs = kept(data, TURNING)
    names = ["average_acceleration", "implicit_midpoint", "energy_momentum"]
    lost = by_name((~runs).sel(scheme=names).sum(["problem", "steps_per_period"]))
    number = runs.sizes["problem"] * runs.sizes["steps_per_period"]
    return Finding(
        f"{listed(lost, data, '.0f')}, of {number} each",
        lost["energy_momentum"] == 0 and lost["average_acceleration"] > 0 and lost["implicit_midpoint"] > 0,
    )


@claim(
    "structures",
    "Explicit schemes are of no use where a mode is stiff, however slow the motion.",
    f"runs on stiff structures that fail or leave the balance of energies by more than {REASONABLE:g} %, in percent",
    whose=PRACTICE,
    reads=["structures"],
    asks={
        "structures.lengths.problem": ["stiff_soft", "elastic_pendulum", "fpu_chain"],
        "structures.schemes": EXPLICIT,
    },
)
def explicit_on_stiff_structures(data):
    runs = kept(data, STIFF)
    lost = _share(~runs, EXPLICIT)
    saved = [name for name in runs.problem.values.tolist() if runs.sel(problem=name, scheme=EXPLICIT).any()]
    return Finding(
        listed(lost, data, ".0f"),
        min(lost.values()) > 100 * MOST,
        f"at the finest steps they resolve the stiff modes of the {joined(saved, data)}" if saved else "",
    )


@claim(
    "structures",
    "Δt < T/20 is reasonable for average acceleration on structures.",
    f"error of the displacement at {RULE} steps in the time scale of the motion, by structure, in percent",
    whose=XIE_EXTENDED,
    reads=["structures"],
    asks={"structures.schemes": ["average_acceleration"], "structures.steps_per_period": [RULE]},
)
def a_twentieth_on_structures(data):
    runs = data["structures"].sel(scheme="average_acceleration", steps_per_period=RULE)
    error = by_name(100 * runs.displacement_error)
    holds, _ = most({name: value <= REASONABLE for name, value in error.items()})
    good = [name for name, value in error.items() if value <= REASONABLE]
    return Finding(
        listed(error, data, ".0f"),
        holds,
        "" if len(good) == len(error) else f"only on {joined(good, data)}",
    )
