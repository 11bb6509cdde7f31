"""Classification of the outcomes of runs, whose step sizes may be too large."""

import enum

import numpy as np
import xarray as xr
from jaxtyping import Float, Int8

from study.io import flags
from study.marching.result import COMPLETED, NO_SOLUTION
from study.observer.diagnostics import APART
from study.observer.outcome import ACCURATE, AT_REST, GROWN


class Outcome(enum.IntEnum):
    """Outcome of a run, from best to worst.

    ``ACCURATE``, ``BOUNDED``, ``DAMPED_TO_REST``, ``IN_THE_WRONG_WELL``, ``CHAOTIC``, ``GROWING``,
    ``BEYOND_THE_LIMIT``, ``NO_SOLUTION_FOUND`` and ``UNBOUNDED``, with the values 0 to 8. A run is beyond the limit if
    its step exceeds the stability limit of the scheme and the force bounds the growth: the run completes, looks like a
    motion and may be wrong by any factor.
    """

    ACCURATE = 0
    BOUNDED = 1
    DAMPED_TO_REST = 2
    IN_THE_WRONG_WELL = 3
    CHAOTIC = 4
    GROWING = 5
    BEYOND_THE_LIMIT = 6
    NO_SOLUTION_FOUND = 7
    UNBOUNDED = 8


OUTCOME_ATTRIBUTES = flags("how the run ended", [outcome.name.lower() for outcome in Outcome], np.int8)

#: Attributes of the outcomes of runs that are judged only by their balance of energies, not by their displacement.
BALANCE_ATTRIBUTES = flags(
    "how the run ended",
    ["energy_kept", *(outcome.name.lower() for outcome in Outcome if outcome != Outcome.ACCURATE)],
    np.int8,
)

#: Explanations of the outcomes of :func:`outcomes`, for readers of the maps.
EXPLANATIONS = (
    f"energy above rest and period stay within {100 * ACCURATE:g} % of the exact ones",
    f"energy or period is wrong by more than {100 * ACCURATE:g} %, but the run does not fail in any other way",
    f"less than {100 * AT_REST:g} % of the energy is left at the end",
    "the motion crosses a barrier for which it lacks the energy",
    "neighbouring runs diverge until a difference of round-off is as large as the motion",
    f"the energy at the end is more than {GROWN:g} times the energy at the start or at the barrier, the higher of both",
    "energy or period is wrong, the step exceeds the stability limit at the stiffest place of the motion, and the "
    "force bounds the growth",
    "no balance of forces is found for the next step, not even with a bracket",
    "the displacement exceeds all bounds or overflows",
)

#: An :class:`Outcome` for each lane, shape (lanes,).
Outcomes = Int8[np.ndarray, "lanes"]

#: A time for each lane, shape (lanes,).
Times = Float[np.ndarray, "lanes"]

#: Outcomes that an event decides, each with the variable that holds the time of the event. An outcome overrides those
#: above it, whichever event came first.
_EVENTS = {
    Outcome.BOUNDED: "inaccurate_from",
    Outcome.DAMPED_TO_REST: "at_rest_from",
    Outcome.IN_THE_WRONG_WELL: "crossed_at",
    Outcome.CHAOTIC: "apart_from",
    Outcome.GROWING: "grown_from",
}


def outcomes(
    runs: xr.Dataset, period: np.ndarray | None = None, beyond: bool | np.ndarray = False
) -> tuple[Outcomes, Times]:
    """Classify how each run of an ensemble ended.

    Parameters
    ----------
    runs
        Ensemble from :func:`study.run`, observed by ``OutcomeObserver.of(problem)`` and ``"lyapunov_exponent"``.
    period
        Exact period of each run (lanes,). If it is given, an accurate run must keep the period too, and the ensemble
        must observe ``"oscillations"``. Otherwise only the energy counts.
    beyond
        Whether the step of each run (lanes,) exceeds the stability limit. A run that would be ``BOUNDED`` is then
        ``BEYOND_THE_LIMIT``.

    Returns
    -------
    outcome
        Values of :class:`study.Outcome`, of shape (lanes,).
    began
        Times at which the outcomes began, of shape (lanes,); NaN for accurate runs, for failed runs, and for runs in
        which only the period is wrong.

    Raises
    ------
    TypeError
        If ``runs`` is not a dataset.
    ValueError
        If the dataset is not an ensemble, or lacks the values of one of these observers.
    """
    if not isinstance(runs, xr.Dataset):
        raise TypeError(f"outcomes takes a dataset of study.run, not {runs!r}.")
    if "lane" not in runs.dims:
        raise ValueError("outcomes need an ensemble: give study.run an array of u0 or of dt.")
    for name in _EVENTS.values():
        if name not in runs and name != "crossed_at":  # only problems with a barrier have this variable
            raise ValueError(
                f"outcomes need '{name}': observe study.OutcomeObserver.of(problem) and 'lyapunov_exponent'."
            )
    if period is not None and "mean_period" not in runs:
        raise ValueError("outcomes with a period need 'mean_period': observe 'oscillations'.")
    outcome, at = np.zeros(runs.sizes["lane"], np.int8), np.full(runs.sizes["lane"], np.nan)
    for ended, event in _EVENTS.items():
        if event in runs:
            times = runs[event].values
            happened = np.isfinite(times)
            outcome[happened], at[happened] = ended, times[happened]
    if period is not None:
        keeps_period = np.abs(runs.mean_period.values / period - 1) <= ACCURATE  # false if the period is NaN
        outcome[(outcome == Outcome.ACCURATE) & ~keeps_period] = Outcome.BOUNDED
    outcome[(outcome == Outcome.BOUNDED) & beyond] = Outcome.BEYOND_THE_LIMIT
    outcome[runs.status != COMPLETED] = Outcome.UNBOUNDED
    outcome[runs.status == NO_SOLUTION] = Outcome.NO_SOLUTION_FOUND
    return outcome, at


def outcomes_of_balance(runs: xr.Dataset, growth: float | np.ndarray, beyond: bool | np.ndarray = False) -> np.ndarray:
    """Classify the outcomes of runs by their balance of energies; the problem may have damping and a load.

    A run that completes is growing if the imbalance is more than a hundred times the energy put in. Otherwise it is
    beyond the limit if its step exceeds the stability limit. Otherwise it is chaotic if a perturbation grows from
    round-off to the size of the motion. Otherwise it keeps its energy if the imbalance is at most 1 % of the energy put
    in. The values ``DAMPED_TO_REST`` and ``IN_THE_WRONG_WELL`` do not occur.

    Parameters
    ----------
    runs
        A run or an ensemble from :func:`study.run`. Without ``"energy_balance"`` among the observers, no run counts as
        keeping its energy or as growing.
    growth
        Natural logarithm of the factor by which a perturbation grows during each run.
    beyond
        Whether the step of each run exceeds the stability limit.

    Returns
    -------
    numpy.ndarray
        Values of :class:`study.Outcome`, of the shape of ``runs.status``. Runs that keep their energy have the value of
        ``ACCURATE``, which ``BALANCE_ATTRIBUTES`` calls ``energy_kept``.
    """
    status = runs.status.values
    imbalance = runs["max_energy_imbalance"].values if "max_energy_imbalance" in runs else np.full(status.shape, np.nan)
    ends = {
        Outcome.NO_SOLUTION_FOUND: status == NO_SOLUTION,
        Outcome.UNBOUNDED: status != COMPLETED,
        Outcome.GROWING: imbalance > GROWN,
        Outcome.BEYOND_THE_LIMIT: np.broadcast_to(beyond, status.shape),
        Outcome.CHAOTIC: np.asarray(growth) > APART * np.log(2),
        Outcome.ACCURATE: imbalance <= ACCURATE,
    }
    return np.select(list(ends.values()), list(ends), Outcome.BOUNDED).astype(np.int8)
