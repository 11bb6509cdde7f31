"""Motions whose rate has a kink where the velocity reverses: smooth hysteresis and fluid dampers.

A mass on a spring of Bouc and Wen obeys

    m ü = f − c u̇ − b k u − (1 − b) k u_y y,    ẏ = (u̇ / u_y) (1 − ½ |y|ⁿ (1 + sgn(y u̇)))

with kinks at u̇ = 0 and y = 0. A force p(u, u̇) may have one at u̇ = 0, as c |u̇|^α sgn u̇ has. CVODE and diffrax find
these events and start anew there. Both solve the rate equation, not the closed solution that the schemes use.
"""

import time
from collections.abc import Callable
from typing import NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from sksundae.cvode import CVODE

from reference.solution import ATOL_BELOW_RTOL, RouteFailed, Solution, Times, check_tolerance, check_trajectory
from study.problem.definition import Problem
from study.problem.materials import BoucWen

SMALLEST_RTOL = 1e-14
#: Most steps between two events, and most events of one motion.
MAX_STEPS = 1_000_000
MAX_EVENTS = 100_000
#: Tolerance of diffrax's event on the interpolant of a step; the motion up to it is then integrated once more.
_EVENT = 1e-8

#: Displacement, velocity and, for smooth hysteresis, y.
State = np.ndarray


def _rate(problem: Problem, state):
    """Right side of the first order equations."""
    u, v, *others = state
    damping = 0.0 if problem.damping is None else problem.damping
    mass = 1.0 if problem.mass is None else problem.mass
    spring = problem.force
    if not isinstance(spring, BoucWen):
        return jnp.stack([v, -(damping * v + problem.internal_force(u, v)) / mass])
    (y,) = others
    k, b, bound = spring.stiffness, spring.hardening, spring.yield_force / spring.stiffness
    force = b * k * u + (1 - b) * k * bound * y
    growth = v / bound * jnp.where(y * v > 0, 1 - jnp.abs(y) ** spring.exponent, 1.0)
    return jnp.stack([v, -(damping * v + force) / mass, growth])


def _start(problem: Problem) -> State:
    u0, v0 = float(problem.u0), float(problem.v0)
    if isinstance(problem.force, BoucWen):
        # the first force is that after a motion straight to u0
        _, (_, y0) = problem.force(problem.u0, problem.v0, problem.history)
        return np.array([u0, v0, float(y0)])
    return np.array([u0, v0])


class _Part(NamedTuple):
    """States at the times asked for up to an event or the end, the time and state there, and the evaluations."""

    found: np.ndarray
    stop: float
    state: State
    evaluations: int


def _by_cvode(problem: Problem, method: str, rtol: float) -> Callable[[float, State, Times], _Part]:
    rate = jax.jit(lambda state: _rate(problem, state))

    def fill(t, state, derivative):
        derivative[:] = rate(state)

    def kinks(t, state, events):
        events[:] = state[1:]

    def until_event(now: float, state: State, ahead: Times) -> _Part:
        kinks.terminal = [True] * (len(state) - 1)  # type: ignore[attr-defined]
        options = {"rtol": rtol, "atol": rtol * ATOL_BELOW_RTOL, "max_num_steps": MAX_STEPS}
        solver = CVODE(fill, method=method, eventsfn=kinks, num_events=len(state) - 1, **options)
        solution = solver.solve(np.append(now, ahead), state)
        if not solution.success:
            raise RouteFailed(f"CVODE {method} did not finish '{problem.title}': {solution.message}")
        ended = solution.t_events is None
        stop, last = (ahead[-1], solution.y[-1]) if ended else (float(solution.t_events[-1]), solution.y_events[-1])
        # of two times alone CVODE returns all its steps between them
        reached = ahead[ahead <= stop]
        return _Part(solution.y[np.searchsorted(solution.t, reached)], stop, last, int(solution.nfev))

    return until_event


@eqx.filter_jit
def _solve(problem: Problem, now, stop, state, signs, t, rtol):
    """Diffrax's states at those of the times ``t`` up to ``stop``, or where one of (u̇, y) loses its sign.

    An event whose sign is zero is not looked for.
    """

    def event(i):
        return lambda t, y, args, **_: jnp.where(signs[i] == 0, -1.0, -signs[i] * y[i + 1])

    events = [event(i) for i in range(len(signs))]
    controller = diffrax.PIDController(rtol=rtol, atol=rtol * ATOL_BELOW_RTOL)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(lambda t, y, problem: _rate(problem, y)),
        diffrax.Dopri8(),
        t0=now,
        t1=stop,
        dt0=None,
        y0=state,
        args=problem,
        stepsize_controller=diffrax.ClipStepSizeController(controller, step_ts=t),
        # the others are cut off, so that one program serves all parts
        saveat=diffrax.SaveAt(ts=jnp.clip(t, now, stop), t1=True),
        event=diffrax.Event(events, optimistix.Newton(rtol=_EVENT, atol=_EVENT), direction=[True] * len(signs)),
        max_steps=MAX_STEPS,
        throw=False,
    )


def _by_diffrax(problem: Problem, t: Times, rtol: float) -> Callable[[float, State, Times], _Part]:
    untitled = problem.untitled()

    def solve(now, stop, state, signs):
        solution = _solve(untitled, np.float64(now), np.float64(stop), state, signs, t, np.float64(rtol))
        if solution.result not in (diffrax.RESULTS.successful, diffrax.RESULTS.event_occurred):
            reason = diffrax.RESULTS[solution.result].splitlines()[0]  # type: ignore[misc]
            raise RouteFailed(f"diffrax Dopri8 did not finish '{problem.title}': {reason}")
        return solution

    def until_event(now: float, state: State, ahead: Times) -> _Part:
        rate = np.asarray(_rate(untitled, jnp.asarray(state)))
        # right after an event its function is zero up to round-off, and its rate tells the sign to come
        small = np.abs(state[1:]) <= _EVENT * np.abs(rate[1:])
        signs = np.sign(np.where(small, rate[1:], state[1:]))
        seen = solve(now, ahead[-1], state, signs)
        evaluations, stop = int(seen.stats["num_steps"]), ahead[-1]
        if seen.result == diffrax.RESULTS.event_occurred:
            # the interpolant of a step is less exact than the step
            stop = float(np.max(seen.ts, where=np.isfinite(seen.ts), initial=now))
            seen = solve(now, stop, state, np.zeros_like(signs))
            evaluations += int(seen.stats["num_steps"])
        states, reached = np.asarray(seen.ys), ahead[ahead <= stop]
        first = len(t) - len(ahead)
        return _Part(states[first : first + len(reached)], stop, states[-1], 13 * evaluations)

    return until_event


def trajectory(problem: Problem, t: Times, rtol: float = 1e-12, method: str = "Adams") -> Solution:
    """Displacement and velocity at the increasing times ``t`` of one mass without load.

    Parameters
    ----------
    problem
        A mass on a spring of Bouc and Wen, or with a force p(u, u̇) whose only kinks are at u̇ = 0.
    t
        Times in seconds.
    rtol
        Relative tolerance; the absolute one is a hundredth of it.
    method
        ``Adams`` or ``BDF`` of CVODE, or ``Dopri8`` of diffrax.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, the times do not increase, or the problem is another one.
    RouteFailed
        If the solver stops early, or there are more than a hundred thousand events.
    """
    route = "diffrax Dopri8" if method == "Dopri8" else f"CVODE {method}"
    check_tolerance(route, rtol, SMALLEST_RTOL)
    check_trajectory(route, problem, t)
    if problem.load is not None or (problem.history is not None and not isinstance(problem.force, BoucWen)):
        raise ValueError(f"'{problem.title}' is no free mass on a Bouc-Wen spring or with a force p(u, u̇).")
    begin = time.perf_counter()
    t = np.asarray(t, float)
    until_event = _by_diffrax(problem, t, rtol) if method == "Dopri8" else _by_cvode(problem, method, rtol)
    now, state, evaluations = 0.0, _start(problem), 0
    found = np.empty((len(t), len(state)))
    found[t == 0] = state
    for _ in range(MAX_EVENTS):
        ahead = t > now
        if not ahead.any():
            return Solution(found[:, 0], found[:, 1], evaluations, time.perf_counter() - begin)
        part = until_event(now, state, t[ahead])
        if part.stop <= now:
            raise RouteFailed(f"{route} does not leave the event of '{problem.title}' at t = {now:g}.")
        found[ahead & (t <= part.stop)] = part.found
        now, state, evaluations = part.stop, part.state, evaluations + part.evaluations
    raise RouteFailed(f"the motion of '{problem.title}' has more than {MAX_EVENTS} events.")
