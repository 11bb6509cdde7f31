"""What becomes of a run at a step size that may be too large."""

import numpy as np
import xarray as xr

from study.datasets import flags
from study.marching.result import NEWTON_FAILED, NOT_FINITE
from study.observer.fate import ACCURATE, GROWN
from study.observer.lyapunov import APART

#: How a run can end, from the best to the worst.
OUTCOMES = (
    "accurate",
    "bounded",
    "damped_to_rest",
    "in_the_wrong_well",
    "chaotic",
    "growing",
    "newton_not_converged",
    "not_finite",
)

OUTCOME_ATTRIBUTES = flags("how the run ended", OUTCOMES, np.int8)

#: What of it an event tells, the worse ones last.
_EVENTS = {
    "bounded": "inaccurate_from",
    "damped_to_rest": "at_rest_from",
    "in_the_wrong_well": "crossed_at",
    "chaotic": "apart_from",
    "growing": "grown_from",
}


def outcomes(runs: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """How each lane ended, as a place in ``OUTCOMES``, and when that began, NaN for accurate ones, both (lanes,).

    Parameters
    ----------
    runs
        What ``study.run`` made of an ensemble under :class:`Fate` and :class:`study.observers.LyapunovExponent`.

    Raises
    ------
    ValueError
        If it is no ensemble, or was observed otherwise.
    """
    if "lane" not in runs.dims:
        raise ValueError("outcomes are told of an ensemble: give study.run an array of u0 or of dt.")
    for name in _EVENTS.values():
        if name not in runs and name != "crossed_at":  # without a barrier nothing can be crossed
            raise ValueError(f"outcomes need '{name}': have Fate.of(problem) and 'lyapunov_exponent' observed.")
    outcome, at = np.zeros(runs.sizes["lane"], np.int8), np.full(runs.sizes["lane"], np.nan)
    for name, event in _EVENTS.items():
        if event in runs:
            times = runs[event].values
            happened = np.isfinite(times)
            outcome[happened], at[happened] = OUTCOMES.index(name), times[happened]
    outcome[runs.status == NEWTON_FAILED] = OUTCOMES.index("newton_not_converged")
    outcome[runs.status == NOT_FINITE] = OUTCOMES.index("not_finite")
    return outcome, at


def outcome_of_balance(run: xr.Dataset, growth: float) -> int:
    """How a run under load and damping ended, as a place in ``OUTCOMES``, by what the balance of its energies tells.

    Accurate is a balance within 1 % of what was put in, growing one beyond a hundred times that. No rest is known, and
    no wells.

    Parameters
    ----------
    run
        What ``study.run`` made under :class:`study.observers.EnergyBalance`.
    growth
        Logarithm of how much a perturbation grows over the run. It is chaotic beyond that of
        :class:`study.observers.LyapunovExponent`.
    """
    if run.status in (NEWTON_FAILED, NOT_FINITE):
        return OUTCOMES.index("newton_not_converged" if run.status == NEWTON_FAILED else "not_finite")
    if run.max_energy_imbalance > 100 * GROWN:
        return OUTCOMES.index("growing")
    if growth > APART * np.log(2):
        return OUTCOMES.index("chaotic")
    return OUTCOMES.index("accurate" if run.max_energy_imbalance <= 100 * ACCURATE else "bounded")
