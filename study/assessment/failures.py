"""How a scheme fails on a problem: the outcome over step size and excitation, and what helps."""

import numpy as np
import xarray as xr

from study.analysis.outcomes import BALANCE_ATTRIBUTES, Outcome, outcomes_of_balance
from study.marching.failure import likely_cause
from study.marching.result import NO_SOLUTION, UNBOUNDED
from study.marching.run import run
from study.mechanics.definition import Problem
from study.mechanics.loads import excited
from study.scheme.base import Scheme

#: Multiples of start and load, and of the coarsest step of a ladder, at which runs are made.
EXCITATIONS = (0.25, 0.5, 1.0, 2.0, 4.0)
STEPS = tuple(2.0**-power for power in range(-1, 7))

#: Outcomes of runs that may be trusted: their energy stays bounded and neighbours stay together.
SAFE = (Outcome.ACCURATE, Outcome.BOUNDED)


def _cure(problem: Problem, scheme: Scheme, outcome: int, dt: float) -> str:
    """Why runs end like this at a step, and what helps, in a sentence or two."""
    if outcome == Outcome.CHAOTIC:
        return (
            "Neighbouring runs part exponentially, so that a long run holds in its statistics only. If finer steps do "
            "not show this, the step makes it; otherwise the problem does."
        )
    cause = likely_cause(problem, scheme, NO_SOLUTION if outcome == Outcome.NO_SOLUTION_FOUND else UNBOUNDED, dt)
    return cause[0].upper() + cause[1:]


def map_of(problem: Problem, scheme: Scheme, duration: float, coarsest: float) -> xr.Dataset:
    """Outcome, Lyapunov exponent and Newton iterations over excitation and step size, with the largest safe step.

    Excitation multiplies the start and the load. A step is safe if at no excitation up to that of the problem, and at
    no finer step, a run fails, grows or turns chaotic.

    Parameters
    ----------
    coarsest
        Coarsest step of a ladder, about which those of the map lie.

    Returns
    -------
    xarray.Dataset
        ``outcome``, ``lyapunov_exponent``, ``max_newton_iterations`` over ``excitation`` and ``map_dt``;
        ``largest_safe_dt`` and ``failure``, a sentence on what limits it.
    """
    steps = np.unique(np.ceil(duration / (coarsest * np.array(STEPS))).astype(int))
    energy = ("energy_balance",) if problem.potential is not None else ()
    shape = (len(EXCITATIONS), len(steps))
    outcome, exponent, iterations = np.zeros(shape, np.int8), np.zeros(shape), np.zeros(shape)
    for e, factor in enumerate(EXCITATIONS):
        runs = run(
            excited(problem, factor, displaced=True),
            scheme,
            dt=duration / steps,
            steps=steps,
            observe=[*energy, "lyapunov_exponent", "newton_iterations"],
            on_failure="ignore",
        )
        outcome[e] = outcomes_of_balance(runs, runs.lyapunov_exponent.values * duration)
        exponent[e], iterations[e] = runs.lyapunov_exponent, runs.max_newton_iterations
    safe = np.isin(outcome, SAFE)[np.array(EXCITATIONS) <= 1].all(axis=0)
    unsafe = np.flatnonzero(~safe)
    largest, why = duration / steps[0], "No run of the map fails."
    if unsafe.size:
        last = unsafe[-1]
        largest = duration / steps[last + 1] if last + 1 < len(steps) else np.nan
        ends = outcome[np.array(EXCITATIONS) <= 1, last]
        why = _cure(problem, scheme, ends.max(), duration / steps[last])
    dims = ("excitation", "map_dt")
    return xr.Dataset(
        {
            "outcome": (dims, outcome, BALANCE_ATTRIBUTES),
            "lyapunov_exponent": (dims, exponent, {"long_name": "largest Lyapunov exponent", "units": "s-1"}),
            "max_newton_iterations": (
                dims,
                iterations,
                {"long_name": "most Newton iterations in a step", "units": "1"},
            ),
            "largest_safe_dt": ((), largest, {"long_name": "largest step without a failure up to here", "units": "s"}),
            "failure": ((), why, {"long_name": "what limits the step, and what helps"}),
        },
        {
            "excitation": ("excitation", list(EXCITATIONS), {"long_name": "multiple of start and load", "units": "1"}),
            "map_dt": ("map_dt", duration / steps, {"long_name": "step size of the map", "units": "s"}),
        },
    )
