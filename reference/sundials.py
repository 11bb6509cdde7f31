"""CVODE of SUNDIALS (Adams), through scikit-sundae."""

import jax
import numpy as np
from sksundae.cvode import CVODE

from study.problem import Problem

RTOL, ATOL = 1e-14, 1e-16
MAX_NUM_STEPS = 1_000_000


def _solver(problem: Problem, **options) -> CVODE:
    force = jax.jit(problem.force)

    def first_order(t, y, derivative):
        derivative[0] = y[1]
        derivative[1] = -force(y[0])

    return CVODE(first_order, method="Adams", rtol=RTOL, atol=ATOL, max_num_steps=MAX_NUM_STEPS, **options)


def _solve(problem: Problem, times, **options):
    start = [float(problem.u0), float(problem.v0)]
    solution = _solver(problem, **options).solve(times, start)
    if not solution.success:
        raise RuntimeError(f"CVODE did not finish '{problem.title}': {solution.message}")
    return solution


def trajectory(problem: Problem, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity at the times ``t`` (shape (n,)) of an undamped, unloaded oscillator.

    Raises
    ------
    RuntimeError
        If CVODE gives up.
    """
    solution = _solve(problem, t)
    return solution.y[:, 0], solution.y[:, 1]


def period(problem: Problem, estimate: float) -> float:
    """Twice the time to the next turning point, by CVODE's root finding on the velocity.

    Parameters
    ----------
    estimate
        The period roughly: where the search ends (at three quarters of it).
    """

    def velocity(t, y, events):
        events[0] = y[1]

    velocity.terminal = [True]  # type: ignore[attr-defined]
    solution = _solve(problem, [0.0, 0.75 * estimate], eventsfn=velocity, num_events=1)
    if solution.t_events is None:
        raise RuntimeError(f"CVODE met no turning point of '{problem.title}' up to t = {0.75 * estimate:g}.")
    return 2 * float(solution.t_events[0])
