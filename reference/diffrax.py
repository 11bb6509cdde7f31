"""Route through diffrax: Runge-Kutta methods under step size control."""

import time
from functools import partial

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

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
from study.algebra.jit import jit
from study.mechanics.definition import Problem

#: Smallest accepted tolerance.
SMALLEST_RTOL = 1e-15
#: Relative tolerance of a first run, which only compiles the program.
LOOSE_RTOL = 1e-3
MAX_STEPS = 1_000_000
#: Smallest number of parts into which the times are divided if the wall time is limited.
PIECES = 256
#: Largest number of values at all times of one call. Each step copies them, so a step among 100,000 values would take
#: ten times as long.
AT_ONCE = 2**13
#: Number of stages that are counted for a step, without the last stage of ``Dopri8`` and ``Tsit5``, which the next step
#: uses again. A stage of these explicit methods evaluates the right side once, an implicit stage several times.
STAGES = {"Dopri8": 13, "Tsit5": 6, "Kvaerno5": 7}


def _solver(method: str):
    """Diffrax's solver; an implicit method solves its equations by the chord iteration.

    Diffrax's default, ``VeryChord``, fails in every second step on these problems and needs six to ten times as many
    steps.
    """
    solver = getattr(diffrax, method)
    if issubclass(solver, diffrax.AbstractImplicitSolver):
        return solver(root_finder=diffrax.with_stepsize_controller_tols(optimistix.Chord)())
    return solver()


def _controller(rtol, stops=None):
    controller = diffrax.PIDController(rtol=rtol, atol=rtol * ATOL_BELOW_RTOL)
    return controller if stops is None else diffrax.ClipStepSizeController(controller, step_ts=stops)


@partial(jit, compiler=eqx.filter_jit)
def _solve(problem: Problem, begin, t, rtol, method: str, max_steps: int):
    """States at the times ``t``, number of steps, status, and the last time and state, the next ``begin``."""
    t0, y0 = begin
    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(right_side),
        _solver(method),
        t0=t0,
        t1=t[-1],
        dt0=None,
        y0=y0,
        args=problem,
        adjoint=diffrax.ForwardMode(),  # a loop without reverse derivatives is traced sooner
        stepsize_controller=_controller(rtol, stops=t),
        saveat=diffrax.SaveAt(ts=t),
        max_steps=max_steps,
        throw=False,
    )
    return solution.ys, solution.stats["num_steps"], solution.result, (t[-1], solution.ys[-1])


@partial(jit, compiler=eqx.filter_jit)
def _solve_with_history(problem: Problem, begin, t, rtol, method: str, max_steps: int):
    """As :func:`_solve`, with the history, which is committed at each time, as part of ``begin``."""

    def stretch(carry, ends):
        y, history, previous = carry
        committed = problem.remembering(history)
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(right_side),
            _solver(method),
            t0=ends[0],
            t1=jnp.where(diffrax.is_okay(previous), ends[1], ends[0]),  # no step after a failure
            dt0=None,
            y0=y,
            args=committed,
            adjoint=diffrax.ForwardMode(),  # a loop without reverse derivatives is traced sooner
            stepsize_controller=_controller(rtol),
            max_steps=max_steps,
            throw=False,
        )
        y = solution.ys[-1]
        result = diffrax.RESULTS.where(diffrax.is_okay(previous), solution.result, previous)
        return (y, committed.at_time(ends[1]).committed(*y).history, result), (y, solution.stats["num_steps"])

    t0, *state = begin
    begin = *state, diffrax.RESULTS.successful
    (*state, result), (states, steps) = jax.lax.scan(stretch, begin, (jnp.append(t0, t[:-1]), t))
    return states, steps.sum(), result, (t[-1], *state)


def _check(problem: Problem, method: str, result) -> None:
    if not diffrax.is_okay(result):
        limited = bool(result == diffrax.RESULTS.max_steps_reached)
        cause = "the limit of its steps was reached" if limited else "it found no step that keeps its tolerance"
        failure = StepLimit if limited else RouteFailed
        raise failure(f"diffrax {method} did not finish '{problem.title}': {cause}")


def trajectory(
    problem: Problem, t: Times, rtol: float = 1e-14, method: str = "Dopri8", max_steps: int = MAX_STEPS
) -> Solution:
    """Displacement and velocity at the increasing times ``t``. Steps end at these times; nothing is interpolated.

    A history is committed at each of these times. From one commit to the next, the force is computed as for a motion
    without reversals. The force is exact if no part of the history reverses between two of the times; see
    :func:`reference.sundials.kinks`.

    Parameters
    ----------
    t
        Times in seconds.
    rtol
        Relative tolerance; the absolute tolerance is a hundredth of it.
    method
        ``Dopri8``, ``Tsit5`` or ``Kvaerno5``.
    max_steps
        Limit of the number of steps, accepted and rejected. For a force with a history, it applies to the steps from
        one time to the next.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, the mass is singular, or the times do not increase.
    StepLimit
        If diffrax reaches the limit of steps.
    RouteFailed
        If diffrax stops early for another reason.
    """
    check_tolerance(f"diffrax {method}", rtol, SMALLEST_RTOL)
    check_trajectory(f"diffrax {method}", problem, t, unknowns=np.inf)
    times, end = np.asarray(t, float), deadline()
    start = jnp.stack([jnp.asarray(problem.u0), jnp.asarray(problem.v0)])
    begin: tuple = jnp.zeros(()), start
    if problem.history is not None:
        begin = *begin, problem.at_time(0.0).committed(*start).history
    solve = partial(_solve if problem.history is None else _solve_with_history, problem.untitled())
    longest = AT_ONCE // start.size if end == np.inf else min(AT_ONCE // start.size, -(-len(t) // PIECES))
    pieces = _pieces(times, max(longest, 1))
    if end == np.inf:
        jax.block_until_ready(
            solve(begin, jnp.asarray(pieces[0]), jnp.asarray(LOOSE_RTOL), method, max_steps)
        )  # compiles
    clock, parts, total = time.perf_counter(), [], 0
    for piece in pieces:
        check_time()
        states, steps, result, begin = solve(begin, jnp.asarray(piece), jnp.asarray(rtol), method, max_steps)
        total += int(steps)
        if total > max_steps and problem.history is None:
            result = diffrax.RESULTS.max_steps_reached
        _check(problem, method, result)
        parts.append(np.asarray(states))
    u, v = np.moveaxis(np.concatenate(parts)[: len(t)], 1, 0)
    return Solution(u, v, total * STAGES[method], time.perf_counter() - clock)


def _pieces(t: Times, longest: int) -> list[Times]:
    """The times in parts of one length, a power of two, so that few programs are compiled; the last one is repeated."""
    length = 1 << min((len(t) - 1).bit_length(), longest.bit_length() - 1)
    return np.split(np.pad(t, (0, -len(t) % length), mode="edge"), -(-len(t) // length))


@partial(jit, compiler=eqx.filter_jit)
def _until(problem: Problem, t1, turning, rtol, method: str):
    """Solution at ``t1``, or earlier where ``turning`` · v becomes positive; zero ``turning`` disables this event."""
    event = diffrax.Event(
        lambda t, y, args, **_: jnp.where(turning == 0, -1.0, turning * y[1]),
        optimistix.Newton(rtol=1e-6, atol=1e-6),
        direction=True,
    )
    return diffrax.diffeqsolve(
        diffrax.ODETerm(right_side),
        _solver(method),
        t0=0.0,
        t1=t1,
        dt0=None,
        y0=jnp.stack([jnp.asarray(problem.u0), jnp.asarray(problem.v0)]),
        args=problem,
        adjoint=diffrax.ForwardMode(),  # a loop without reverse derivatives is traced sooner
        stepsize_controller=_controller(rtol),
        event=event,
        max_steps=MAX_STEPS,
        throw=False,
    )


def period(problem: Problem, estimate: float, rtol: float = 1e-14, method: str = "Dopri8") -> float:
    """Period of a free oscillator: twice the time from rest to the next turning point, where v = 0.

    The turning point is found on the interpolant of a step, which has a lower order than the step. Two Newton
    corrections t ← t − v/v̇, each with a new integration up to t, remove the error of the interpolant.

    Raises
    ------
    ValueError
        If :func:`reference.solution.release` refuses the problem or the estimate.
    RouteFailed
        If no turning point comes within three quarters of ``estimate``, or diffrax stops early.
    """
    sign = release(f"diffrax {method}", problem, estimate)
    untitled = problem.untitled()
    # all numbers are arrays of one type, because otherwise each call would be compiled again
    tolerance = np.float64(rtol)
    solution = _until(untitled, np.float64(0.75 * estimate), np.float64(-sign), tolerance, method)
    _check(problem, method, solution.result)
    if solution.result != diffrax.RESULTS.event_occurred:
        raise RouteFailed(f"diffrax {method} met no turning point of '{problem.title}' up to t = {0.75 * estimate:g}.")
    t = float(solution.ts[-1])
    for _ in range(2):
        y = _until(untitled, np.float64(t), np.float64(0.0), tolerance, method).ys[-1]
        t -= float(y[1] / right_side(t, y, problem)[1])
    return 2 * t
