"""Route through CVODE of SUNDIALS (scikit-sundae): the Adams and BDF methods."""

import io
import math
import os
import time
from collections.abc import Callable
from contextlib import redirect_stdout, suppress

import jax
import jax.numpy as jnp
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
from study.algebra.deadline import check_time, deadline
from study.mechanics.definition import Problem
from study.mechanics.internal_force import switches

#: Smallest accepted tolerance; below it round-off dominates CVODE's estimate of the error.
SMALLEST_RTOL = 1e-15
MAX_NUM_STEPS = 1_000_000
#: Status codes of CVODE at a root and at the limit of steps, from cvode.h.
CV_ROOT_RETURN, CV_TOO_MUCH_WORK = 2, -1
#: Relative tolerance of the motion along which kinks are found.
KINK_RTOL = 1e-12
#: Time, relative to the duration, by which events of a force with a history are evaluated ahead of the motion. Of
#: several kinks within this time, only the first is kept.
AHEAD = 1e-10
#: A force switches without end if this number of kinks, or of steps, have a mean distance below ``AHEAD``.
ENDLESS_KINKS, ENDLESS_STEPS = 20, 5_000

# CVODE prints warnings of tiny steps itself; a failure is an exception here
os.environ.setdefault("SUNLOGGER_WARNING_FILENAME", os.devnull)


class Sticking(RouteFailed):
    """A motion that stays at a jump of the force, as dry friction does at rest."""


class _Motion:
    """A problem with the committed history of its motion, which is None for a force without a history."""

    def __init__(self, problem: Problem):
        shape = (2, *np.shape(problem.u0))
        self.problem, self.start = problem, np.concatenate([np.ravel(problem.u0), np.ravel(problem.v0)])
        self.rate = jax.jit(lambda t, y, h: right_side(t, y.reshape(shape), problem.remembering(h)).ravel())
        self._committed = jax.jit(
            lambda t, y, h: problem.remembering(h).at_time(t).committed(*y.reshape(shape)).history
        )
        self.history = problem.history
        self.commit(0.0, self.start)

    def commit(self, t: float, y: np.ndarray) -> None:
        """Commit the history of the motion up to a state at the time t."""
        if self.history is not None:
            self.history = self._committed(t, y, self.history)


def _in_time(fill: Callable) -> Callable:
    """The function f(t, y, ẏ), which raises ``TimeoutError`` after the deadline."""
    end = deadline()
    if end == math.inf:
        return fill

    def checked(t, y, rate):
        check_time(end)
        fill(t, y, rate)

    return checked


def _right_side_of(motion: _Motion) -> Callable:
    """Function f(t, y, ẏ) that writes ẏ: plain Python for one unknown if it can be translated, compiled otherwise."""
    if np.ndim(motion.problem.u0) == 0 and motion.history is None:
        from reference.symbolic import Untranslatable, as_python  # here, because SymPy takes a second to import

        with suppress(Untranslatable):
            acceleration = as_python(motion.problem)

            def fill(t, y, rate):
                u, v = y.tolist()
                rate[0], rate[1] = v, acceleration(t, u, v)

            return fill

    def fill_all(t, y, rate):
        rate[:] = motion.rate(t, y, motion.history)

    return fill_all


def _solver(motion: _Motion, rtol: float, method: str, **options) -> CVODE:
    check_tolerance(f"CVODE {method}", rtol, SMALLEST_RTOL)
    return CVODE(
        _in_time(_right_side_of(motion)),
        method=method,
        rtol=rtol,
        atol=rtol * ATOL_BELOW_RTOL,
        max_num_steps=options.pop("max_num_steps", MAX_NUM_STEPS),
        **options,
    )


def _quiet(call: Callable, *arguments, **options):
    """The result of a call of CVODE without the lines that it prints on a failure, which an exception states."""
    with redirect_stdout(io.StringIO()):
        return call(*arguments, **options)


def _check(problem: Problem, method: str, solution) -> None:
    if not solution.success:
        limited = solution.status == CV_TOO_MUCH_WORK
        cause = "the limit of its steps was reached" if limited else "it found no step that keeps its tolerance"
        failure = StepLimit if limited else RouteFailed
        raise failure(f"CVODE {method} did not finish '{problem.title}': {cause}")


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
    A history is committed at each of the times ``t``. From one commit to the next, the force is computed as for a
    motion without reversals. The force is exact if no part of the history reverses between two of the times, so
    ``restarts`` must contain the times of reversals.

    Parameters
    ----------
    t
        Times in seconds.
    rtol
        Relative tolerance; the absolute tolerance is a hundredth of it.
    method
        ``Adams`` or ``BDF``.
    max_num_steps
        Limit of steps from one time to the next.
    kinks
        Times at which the load has a kink, in ascending order; no step crosses one.
    restarts
        Times, all among ``t``, at which CVODE restarts, because past values cannot be extrapolated beyond a kink.

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
    motion = _Motion(problem)
    solver = _solver(motion, rtol, method, max_num_steps=max_num_steps)
    y = np.empty((len(t), 2, *np.shape(problem.u0)))
    stops = np.concatenate([[] if kinks is None else kinks, [np.inf]])
    restarted = np.isin(t, [] if restarts is None else restarts)
    stops = np.union1d(stops, t[restarted])
    start, evaluations = time.perf_counter(), 0
    # ``solve`` loops in compiled code; for only two times it would return all steps between them
    if len(t) > 2 and motion.history is None and not np.isfinite(stops).any():
        solution = _quiet(solver.solve, [*([] if t[0] == 0 else [0.0]), *t], motion.start)
        _check(problem, method, solution)
        y = solution.y[-len(t) :].reshape(y.shape)
        return Solution(y[:, 0], y[:, 1], int(solution.nfev), time.perf_counter() - start)
    solution = solver.init_step(0.0, motion.start)
    for i, end in enumerate(map(float, t)):
        if end > 0:
            stop = stops[np.searchsorted(stops, end)]
            solution = _quiet(solver.step, end, tstop=float(stop) if np.isfinite(stop) else None)
            _check(problem, method, solution)
        y[i] = solution.y.reshape(y[i].shape)
        motion.commit(end, solution.y)
        if restarted[i]:
            evaluations += solution.nfev
            solution = solver.init_step(end, solution.y)
    return Solution(y[:, 0], y[:, 1], int(evaluations + solution.nfev), time.perf_counter() - start)


def _switches(problem: Problem, t, u, v):
    """The switches of the force, and those of the time if the force takes it."""
    if not problem.takes_time:
        return switches(problem.varying_force, u, v)
    return switches(lambda t, u, v: problem.at_time(t).varying_force(u, v), t, u, v)


def _events_of_history(problem: Problem, ahead: float, t, u, v):
    """Numbers whose sign changes where the force has a kink or where one of the numbers of its history reverses."""
    # evaluated ahead of the motion, because right after a commit a yield point is reached only up to round-off
    u = u + ahead * v
    rates = jax.tree.leaves(jax.jvp(lambda u: problem.at_time(t).committed(u, v).history, (u,), (v,))[1])
    events = jnp.concatenate([_switches(problem, t, u, v), *map(jnp.ravel, rates)])
    # zero becomes one, because CVODE ignores a function that begins with zero, such as the rate of a history at rest
    return jnp.where(events == 0, 1.0, events)


def kinks(problem: Problem, duration: float, load_kinks: Times, method: str = "Adams") -> Times:
    """Times at which the internal force may have a kink, by CVODE's root finding.

    The force may have a kink where one of its switches (:func:`study.mechanics.internal_force.switches`) changes its
    sign, or where its history reverses. A history reverses where the rate of one of its numbers changes its sign; it is
    committed at all times found. A zero without a change of sign is not found. No kink is found after the time at which
    CVODE stops.

    Parameters
    ----------
    load_kinks
        Times at which the load has a kink, in ascending order; no step crosses one.

    Raises
    ------
    Sticking
        If the force switches without end.
    """
    motion, shape, ahead = (
        _Motion(problem),
        (2, *np.shape(problem.u0)),
        AHEAD * duration if problem.history is not None else 0.0,
    )

    @jax.jit
    def events(t, y, history):
        if history is None:
            return _switches(problem, t, *y.reshape(shape))
        return _events_of_history(problem.remembering(history), ahead, t, *y.reshape(shape))

    def fill(t, y, values):
        values[:] = events(t, y, motion.history)

    number = len(events(0.0, motion.start, motion.history))
    if not number:
        return np.zeros(0)
    fill.terminal = [False] * number  # type: ignore[attr-defined]
    limits = {"max_num_steps": ENDLESS_STEPS, "num_events": number}
    solver, times = _solver(motion, KINK_RTOL, method, eventsfn=fill, **limits), [-np.inf]
    solution, shortest = solver.init_step(0.0, motion.start), AHEAD * duration
    for end in map(float, [*load_kinks, duration]):
        while (solution.success or solution.status == CV_TOO_MUCH_WORK) and solution.t < end:
            last = float(solution.t)
            solution = _quiet(solver.step, end, tstop=end)
            if solution.status == CV_TOO_MUCH_WORK and solution.t - last < ENDLESS_STEPS * shortest:
                raise Sticking(f"the force of '{problem.title}' switches without end from t = {last:.4g}")
            if solution.status == CV_ROOT_RETURN and solution.t > times[-1] + ahead:
                times.append(float(solution.t))
                first = times[max(len(times) - ENDLESS_KINKS, 0)]
                if times[-1] - first < ENDLESS_KINKS * shortest:
                    raise Sticking(f"the force of '{problem.title}' switches without end from t = {first:.4g}")
                if motion.history is not None:
                    motion.commit(solution.t, solution.y)
                    solution = solver.init_step(solution.t, solution.y)
    return np.array(times[1:])


def period(problem: Problem, estimate: float, rtol: float = 1e-15, method: str = "Adams") -> float:
    """Period of a free oscillator: twice the time from rest to the next turning point, by CVODE's root finding on v.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, or :func:`reference.solution.release` refuses the problem or the estimate.
    RouteFailed
        If no turning point comes within three quarters of ``estimate``, or CVODE stops early.
    """
    sign = release(f"CVODE {method}", problem, estimate)

    def velocity(t, y, events):
        events[0] = y[1]

    velocity.terminal = [True]  # type: ignore[attr-defined]
    velocity.direction = [-int(sign)]  # type: ignore[attr-defined]
    motion = _Motion(problem)
    solver = _solver(motion, rtol, method, eventsfn=velocity, num_events=1)
    solution = _quiet(solver.solve, [0.0, 0.75 * estimate], motion.start)
    _check(problem, method, solution)
    if solution.t_events is None:
        raise RouteFailed(f"CVODE {method} met no turning point of '{problem.title}' up to t = {0.75 * estimate:g}.")
    return 2 * float(solution.t_events[0])
