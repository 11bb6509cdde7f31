"""Route through CVODE of SUNDIALS (scikit-sundae): the Adams and BDF methods."""

import time
from contextlib import suppress

import jax
import numpy as np
from sksundae.cvode import CVODE

from reference.solution import (
    ATOL_BELOW_RTOL,
    RouteFailed,
    Solution,
    StepLimit,
    Times,
    check_tolerance,
    check_trajectory,
    release,
    right_side,
)
from study.problem.definition import Problem
from study.problem.internal_force import switches

#: Smallest tolerance that is accepted; below it round-off dominates CVODE's estimate of the error.
SMALLEST_RTOL = 1e-15
MAX_NUM_STEPS = 1_000_000
#: Status of CVODE at a root and at its limit of steps, from cvode.h.
CV_ROOT_RETURN, CV_TOO_MUCH_WORK = 2, -1
#: Relative tolerance of the motion along which kinks are found.
KINK_RTOL = 1e-12


def _right_side_of(problem: Problem):
    """Function f(t, y, ẏ) that writes ẏ: plain Python for one unknown whose functions translate, otherwise compiled."""
    if np.ndim(problem.u0) == 0:
        from reference.symbolic import Untranslatable, as_python  # here, because importing SymPy takes a second

        with suppress(Untranslatable):
            acceleration = as_python(problem)

            def fill(t, y, rate):
                u, v = y.tolist()
                rate[0], rate[1] = v, acceleration(t, u, v)

            return fill
    shape = (2, *np.shape(problem.u0))
    compiled = jax.jit(lambda t, y: right_side(t, y.reshape(shape), problem).ravel())

    def fill_all(t, y, rate):
        rate[:] = compiled(t, y)

    return fill_all


def _solver(problem: Problem, rtol: float, method: str, **options) -> CVODE:
    check_tolerance(f"CVODE {method}", rtol, SMALLEST_RTOL)
    return CVODE(
        _right_side_of(problem),
        method=method,
        rtol=rtol,
        atol=rtol * ATOL_BELOW_RTOL,
        max_num_steps=options.pop("max_num_steps", MAX_NUM_STEPS),
        **options,
    )


def _start(problem: Problem) -> np.ndarray:
    return np.concatenate([np.ravel(problem.u0), np.ravel(problem.v0)])


def _check(problem: Problem, method: str, solution) -> None:
    if not solution.success:
        failure = StepLimit if solution.status == CV_TOO_MUCH_WORK else RouteFailed
        raise failure(f"CVODE {method} did not finish '{problem.title}': {solution.message}")


def trajectory(
    problem: Problem,
    t: Times,
    rtol: float = 1e-15,
    method: str = "Adams",
    max_num_steps: int = MAX_NUM_STEPS,
    kinks: Times | None = None,
    restarts: Times | None = None,
) -> Solution:
    """Displacement and velocity at the increasing times ``t``.

    Values come from CVODE's own polynomial of the step that contains each time, which is as accurate as the step.
    Stopping at each time instead doubles the measured error, because every stop interrupts the sequence of step sizes.

    Parameters
    ----------
    t
        Times in seconds.
    rtol
        Relative tolerance; the absolute one is a hundredth of it.
    method
        ``Adams`` or ``BDF``.
    max_num_steps
        Limit of steps from one time to the next.
    kinks
        Times at which the load has a kink, in ascending order; no step crosses one.
    restarts
        Times, all among ``t``, at which CVODE starts anew, since what it remembers of the motion before is of no use.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, the mass is singular, or the times do not increase.
    StepLimit
        If CVODE reaches the limit of steps.
    RouteFailed
        If CVODE stops early for another reason.
    """
    check_trajectory(f"CVODE {method}", problem, t, unknowns=np.inf)
    solver = _solver(problem, rtol, method, max_num_steps=max_num_steps)
    y = np.empty((len(t), 2, *np.shape(problem.u0)))
    stops = np.concatenate([[] if kinks is None else kinks, [np.inf]])
    anew = np.isin(t, [] if restarts is None else restarts)
    stops = np.union1d(stops, t[anew])
    start, evaluations = time.perf_counter(), 0
    solution = solver.init_step(0.0, _start(problem))
    for i, until in enumerate(map(float, t)):
        if until > 0:
            stop = stops[np.searchsorted(stops, until)]
            solution = solver.step(until, tstop=float(stop) if np.isfinite(stop) else None)
            _check(problem, method, solution)
        y[i] = solution.y.reshape(y[i].shape)
        if anew[i]:
            evaluations += solution.nfev
            solution = solver.init_step(until, solution.y)
    return Solution(y[:, 0], y[:, 1], int(evaluations + solution.nfev), time.perf_counter() - start)


def kinks(problem: Problem, duration: float, of_load: Times, method: str = "Adams") -> Times:
    """Times at which a switch of the internal force changes its sign, by CVODE's root finding.

    There the force may have a kink; see :func:`study.problem.internal_force.switches`. A touch without a change of sign
    is not found, and nothing after the time at which CVODE stops, as it does where a force switches without end.

    Parameters
    ----------
    of_load
        Times at which the load has a kink, in ascending order; no step crosses one.

    Raises
    ------
    ValueError
        If the mass is singular.
    """
    shape = (2, *np.shape(problem.u0))
    compiled = jax.jit(lambda y: switches(problem.varying_force, *y.reshape(shape)))
    number = len(compiled(_start(problem)))
    if not number:
        return np.zeros(0)

    def fill(t, y, events):
        events[:] = compiled(y)

    fill.terminal = [False] * number  # type: ignore[attr-defined]
    solver, found = _solver(problem, KINK_RTOL, method, eventsfn=fill, num_events=number), []
    solution = solver.init_step(0.0, _start(problem))
    for end in map(float, [*of_load, duration]):
        while solution.success and solution.t < end:
            solution = solver.step(end, tstop=end)
            if solution.status == CV_ROOT_RETURN:
                found.append(float(solution.t))
    return np.unique(np.asarray(found, float))


def period(problem: Problem, estimate: float, rtol: float = 1e-15, method: str = "Adams") -> float:
    """Period of a free oscillator: twice the time from rest to the next turning point, by CVODE's root finding on v.

    Raises
    ------
    ValueError
        If the problem has no such period.
    RouteFailed
        If no turning point comes within three quarters of ``estimate``.
    """
    sign = release(f"CVODE {method}", problem, estimate)

    def velocity(t, y, events):
        events[0] = y[1]

    velocity.terminal = [True]  # type: ignore[attr-defined]
    velocity.direction = [-int(sign)]  # type: ignore[attr-defined]
    solver = _solver(problem, rtol, method, eventsfn=velocity, num_events=1)
    solution = solver.solve([0.0, 0.75 * estimate], _start(problem))
    _check(problem, method, solution)
    if solution.t_events is None:
        raise RouteFailed(f"CVODE {method} met no turning point of '{problem.title}' up to t = {0.75 * estimate:g}.")
    return 2 * float(solution.t_events[0])
