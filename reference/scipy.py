"""Route through SciPy's initial value solvers DOP853 and Radau."""

import time

import numpy as np
from scipy.integrate import solve_ivp

from reference.solution import ATOL_BELOW_RTOL, RouteFailed, Solution, Times, check_tolerance, check_trajectory
from reference.symbolic import as_python
from study.mechanics.definition import Problem

#: Smallest relative tolerance; SciPy increases smaller tolerances to this value.
SMALLEST_RTOL = 100 * np.finfo(float).eps


def trajectory(problem: Problem, t: Times, rtol: float = 1e-13, method: str = "DOP853") -> Solution:
    """Displacement and velocity at the increasing times ``t``, from the interpolant of the step at each time.

    Parameters
    ----------
    t
        Times in seconds.
    rtol
        Relative tolerance; the absolute tolerance is a hundredth of it.
    method
        ``DOP853`` or ``Radau``.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, the problem has more than one unknown, its mass is singular, one of its
        functions has no translation (:mod:`reference.symbolic`), or the times do not increase.
    RouteFailed
        If SciPy does not reach the last time.
    """
    check_tolerance(f"SciPy {method}", rtol, SMALLEST_RTOL)
    check_trajectory(f"SciPy {method}", problem, t)
    acceleration = as_python(problem)

    def right_side(t, y):
        u, v = y.tolist()
        return [v, acceleration(t, u, v)]

    start = time.perf_counter()
    solution = solve_ivp(
        right_side,
        (0.0, float(t[-1])),
        [float(problem.u0), float(problem.v0)],
        method=method,
        t_eval=t,
        rtol=rtol,
        atol=rtol * ATOL_BELOW_RTOL,
    )
    seconds = time.perf_counter() - start
    if not solution.success:
        raise RouteFailed(f"SciPy {method} did not finish '{problem.title}': {solution.message}")
    return Solution(solution.y[0], solution.y[1], int(solution.nfev), seconds)
