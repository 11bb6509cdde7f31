"""How a scheme fails on a problem: the outcome over step size and excitation, and remedies."""

import numpy as np
import xarray as xr

from study.analysis.outcomes import BALANCE_ATTRIBUTES, Outcome, outcomes_of_balance
from study.marching.failure import likely_cause
from study.marching.result import NO_SOLUTION, UNBOUNDED
from study.marching.run import sweep
from study.marching.stability import SmallMotion, at_start, excess, has_limit, stable_part
from study.mechanics.definition import Problem
from study.mechanics.loads import excited
from study.scheme.base import Scheme

#: Multiples of start and load in the map.
EXCITATIONS = (0.25, 0.5, 1.0, 2.0, 4.0)

#: Step sizes of the map, divided by the coarsest step of a search.
STEPS = 2.0 ** -np.arange(-1, 6.25, 0.25)

#: Largest number of steps of a run at those step sizes of the map that are finer than the coarsest step of a search.
MOST_STEPS = 30_000

#: Outcomes of reliable runs: the energy stays bounded and neighbouring runs stay together.
SAFE = (Outcome.ACCURATE, Outcome.BOUNDED)

_STABLE = {"long_name": "largest step within the stability limit at the start", "units": "s"}
_EXCITATION = {"long_name": "multiple of start and load", "units": "1"}


def _cause(problem: Problem, scheme: Scheme, outcome: int, dt: float, motion: SmallMotion | None) -> str:
    """Cause of an unsafe outcome at the step ``dt``, and remedies, in one or two sentences."""
    if outcome == Outcome.CHAOTIC:
        return (
            "Neighbouring runs diverge exponentially, so only the statistics of a long run are meaningful. If finer "
            "steps do not show this, the step size causes it; otherwise the problem does."
        )
    status = NO_SOLUTION if outcome == Outcome.NO_SOLUTION_FOUND else UNBOUNDED
    cause = likely_cause(problem, scheme, status, dt, motion)
    return cause[0].upper() + cause[1:]


def _stability(
    problem: Problem, scheme: Scheme, duration: float, dt: np.ndarray
) -> tuple[SmallMotion | None, np.ndarray, float]:
    """Small motions about the start, whether steps in descending order are beyond their limit, and the limit.

    The motions are None for a scheme without a limit. The limit is infinite if all steps are within it.
    """
    if not has_limit(scheme, problem):
        return None, np.zeros(len(dt), bool), np.inf
    motion = at_start(problem)
    beyond = excess(scheme, motion, dt, np.ceil(duration / dt).astype(int)) > 0
    return motion, beyond, dt[0] * stable_part(scheme, motion, dt[0])[0] if beyond[0] else np.inf


def limit_of(problem: Problem, scheme: Scheme, duration: float, coarsest: float) -> xr.Dataset:
    """``stable_step_size`` of :func:`map_of` for the given start and load, which needs no run."""
    *_, stable = _stability(problem, scheme, duration, coarsest * STEPS[:1])
    return xr.Dataset(
        {"stable_step_size": ("excitation", [stable], _STABLE)}, {"excitation": ("excitation", [1.0], _EXCITATION)}
    )


def map_of(problem: Problem, scheme: Scheme, duration: float, coarsest: float, recommended: np.ndarray) -> xr.Dataset:
    """Outcome, Lyapunov exponent and Newton iterations over excitation and step size, with the largest safe step.

    Excitation is the multiple of start and load. A step is safe if no run with this or a finer step fails, grows,
    becomes chaotic or is beyond the stability limit at an excitation of at most one.

    Parameters
    ----------
    coarsest
        Coarsest step of a search. The map covers steps from twice this step down to 1/64 of it. Steps finer than
        ``coarsest`` are left out if their runs have more than ``MOST_STEPS`` steps.
    recommended
        Recommended steps. Runs with recommended steps coarser than the finest step of the map count for
        ``largest_safe_step_size``, but the map does not show them.

    Returns
    -------
    xarray.Dataset
        ``outcome``, ``lyapunov_exponent``, ``max_newton_iterations`` over ``excitation`` and ``map_step_size``;
        ``stable_step_size`` over ``excitation``, the largest step within the stability limit for small motions about
        the start (:mod:`study.marching.stability`), infinite if all steps of the map are, zero for a scheme that is
        unstable at every step; ``largest_safe_step_size``, NaN if no step is safe; and ``failure``, which states the
        cause of this limit.
    """
    drawn = coarsest * STEPS[STEPS >= min(1.0, duration / (coarsest * MOST_STEPS))]
    dt = np.unique(np.append(recommended[recommended > drawn[-1]], drawn))[::-1]
    energy = ("energy_balance",) if problem.potential is not None else ()
    shape = (len(EXCITATIONS), len(dt))
    outcome, exponent, iterations = np.zeros(shape, np.int8), np.zeros(shape), np.zeros(shape)
    stable, steps = np.zeros(len(EXCITATIONS)), np.ceil(duration / dt).astype(int)
    motions: list[SmallMotion | None] = []
    for e, factor in enumerate(EXCITATIONS):
        scaled = excited(problem, factor, displaced=True)
        motion, beyond, stable[e] = _stability(scaled, scheme, duration, dt)
        motions.append(motion)
        observe = [*energy, "lyapunov_exponent", "newton_iterations"]
        runs = sweep(scaled, scheme, dt=dt, steps=steps, observe=observe)
        outcome[e] = outcomes_of_balance(runs, runs.lyapunov_exponent.values * duration, beyond)
        exponent[e], iterations[e] = runs.lyapunov_exponent, runs.max_newton_iterations
    safe = np.isin(outcome, SAFE)[np.array(EXCITATIONS) <= 1].all(axis=0)
    unsafe = np.flatnonzero(~safe)
    largest, cause = dt[0], "No run of the map fails."
    if unsafe.size:
        last = unsafe[-1]
        largest = dt[last + 1] if last + 1 < len(dt) else np.nan
        ends = outcome[np.array(EXCITATIONS) <= 1, last]
        cause = _cause(problem, scheme, ends.max(), dt[last], motions[ends.argmax()])
    shown = np.isin(dt, drawn)
    dims = ("excitation", "map_step_size")
    return xr.Dataset(
        {
            "outcome": (dims, outcome[:, shown], BALANCE_ATTRIBUTES),
            "lyapunov_exponent": (dims, exponent[:, shown], {"long_name": "largest Lyapunov exponent", "units": "s-1"}),
            "max_newton_iterations": (
                dims,
                iterations[:, shown],
                {"long_name": "most Newton iterations in a step", "units": "1"},
            ),
            "stable_step_size": ("excitation", stable, _STABLE),
            "largest_safe_step_size": (
                (),
                largest,
                {"long_name": "largest step up to which no run fails", "units": "s"},
            ),
            "failure": ((), cause, {"long_name": "cause of the limit of the step, and remedies"}),
        },
        {
            "excitation": ("excitation", list(EXCITATIONS), _EXCITATION),
            "map_step_size": ("map_step_size", dt[shown], {"long_name": "step size of the map", "units": "s"}),
        },
    )


def failed_runs(assessed: xr.Dataset) -> list[tuple[str, str, str]]:
    """Scheme, step and reason of each failed run; empty if the dataset has no variable ``reason``."""
    if "reason" not in assessed:
        return []
    reasons = assessed.reason.stack(run=["scheme", "step_size"])
    return [
        (reason.scheme.item(), f"{reason.step_size.item():.4g}", reason.item()) for reason in reasons if reason.item()
    ]
