"""Route through the Taylor method of heyoka, in double precision and beyond."""

import time
from collections.abc import Callable, Sequence

import heyoka as hy
import numpy as np

from reference.solution import RouteFailed, Solution, check_tolerance, check_trajectory, release
from reference.symbolic import expression, first_order
from study.algebra.deadline import check_time, deadline
from study.mechanics.definition import Problem

#: Bits of the significand of a double.
DOUBLE = 53
_EPS = np.finfo(float).eps


def _number(value, bits: int):
    return float(value) if bits == DOUBLE else hy.real(value, bits)


def _integrator(problem: Problem, bits: int, formulation: Callable, **options) -> hy.taylor_adaptive:
    """Integrator of a formulation at t = 0; its states are u, v and, in a formulation of three states, p(u)."""
    system = formulation(problem)
    start = [_number(float(problem.u0), bits), _number(float(problem.v0), bits)]
    kind = {} if bits == DOUBLE else {"fp_type": hy.real, "prec": bits}
    if len(system) == 3:
        u = hy.make_vars("u")
        force = hy.cfunc([expression(problem.static_force, u)], [u], **kind)
        start.append(force(np.array(start[:1]))[0])
    return hy.taylor_adaptive(system, start, **kind, **options)


def _check(problem: Problem, outcome, time) -> None:
    if outcome == hy.taylor_outcome.err_nf_state:
        after = f" after t = {time:g}" if np.isfinite(time) else ""
        raise RouteFailed(f"the motion, force or potential of '{problem.title}' is no longer finite{after}.")
    if outcome not in (hy.taylor_outcome.time_limit, hy.taylor_outcome.success):
        raise RouteFailed(f"heyoka did not finish '{problem.title}': {outcome}.")


def trajectory(
    problem: Problem, t: Sequence, rtol: float = _EPS, bits: int = DOUBLE, formulation: Callable = first_order
) -> Solution:
    """Displacement and velocity at the increasing times ``t``, from the Taylor series of the step at each time.

    Parameters
    ----------
    t
        Times from 0 on, as floats, or as numbers of heyoka if ``bits`` exceeds the 53 of a double.
    rtol
        Relative tolerance in double precision; with more bits the tolerance is the precision itself.
    bits
        Bits of the significand.
    formulation
        ``first_order`` or ``with_force_as_state`` of :mod:`reference.symbolic`.

    Raises
    ------
    ValueError
        If the tolerance cannot be reached, the problem has more than one unknown, its mass is singular, one of its
        functions has no translation (:mod:`reference.symbolic`), or the times do not increase.
    RouteFailed
        If the integration ends early.
    """
    check_trajectory("heyoka", problem, t)
    if bits == DOUBLE:
        check_tolerance("heyoka", rtol, _EPS)
    options = {"tol": float(rtol)} if bits == DOUBLE else {}
    integrator = _integrator(problem, bits, formulation, **options)
    times = t if t[0] == 0 else [0.0, *t]  # the grid must begin at the initial time of the integrator
    grid = np.array([_number(value, bits) for value in times])
    start, end = time.perf_counter(), deadline()
    in_time = {} if end == np.inf else {"callback": lambda integrator: time.monotonic() <= end}
    outcome, *_, steps, _, states = integrator.propagate_grid(grid, **in_time)
    seconds = time.perf_counter() - start
    if outcome == hy.taylor_outcome.cb_stop:
        check_time()
    _check(problem, outcome, integrator.time)
    return Solution(states[-len(t) :, 0], states[-len(t) :, 1], steps * integrator.order, seconds)


def period(
    problem: Problem, estimate: float, rtol: float = _EPS, bits: int = DOUBLE, formulation: Callable = first_order
):
    """Period of a free oscillator: twice the time from rest to the next turning point, where v = 0.

    The event v = 0 is found on the Taylor series. The period is a float, or a number of heyoka if ``bits`` exceeds the
    53 of a double.

    Raises
    ------
    ValueError
        If :func:`reference.solution.release` refuses the problem or the estimate, or a function of the problem has no
        translation (:mod:`reference.symbolic`).
    RouteFailed
        If no turning point comes within three quarters of ``estimate``, or the integration ends early.
    """
    sign = release("heyoka", problem, estimate)
    crossings: list = []
    event = hy.nt_event_dbl if bits == DOUBLE else hy.nt_event_real
    turning = event(-float(sign) * hy.make_vars("v"), lambda _, t, direction: crossings.append((t, direction)))
    options = {"tol": float(rtol)} if bits == DOUBLE else {}
    integrator = _integrator(problem, bits, formulation, nt_events=[turning], **options)
    outcome, *_ = integrator.propagate_until(_number(0.75 * estimate, bits))
    _check(problem, outcome, integrator.time)
    ends = [t for t, direction in crossings if direction > 0]
    if not ends:
        raise RouteFailed(f"heyoka met no turning point of '{problem.title}' up to t = {0.75 * estimate:g}.")
    return 2 * ends[0]
