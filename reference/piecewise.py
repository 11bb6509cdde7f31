r"""Exact motion of one mass on a spring that is linear in pieces, from event to event.

An event is a yield point, a reversal, a change of contact or a kink of the load. Between two events the motion obeys

.. math::

    m \ddot u + c \dot u + k u = q

with q, the load less the offset of the piece, linear in time. The solution applies a matrix exponential to
(u, u̇, q, q̇). An event of the spring is bracketed within a small part of the shortest period, and then found by
Brent's method on this solution.
"""

import time
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import jax
import numpy as np
import scipy.linalg
import scipy.optimize

from reference.solution import RouteFailed, Solution, Times
from study.materials import Elastoplastic, Gap
from study.mechanics.definition import Problem

#: Default number of instants in the shortest period of the spring at which events are sought.
PLACES = 200

#: Largest number of events of one motion.
MOST_EVENTS = 1_000_000

#: Largest value of an event function, relative to the state, that counts as round-off.
ROUND_OFF = 1e-13


class _Piece(NamedTuple):
    """A piece of a spring with the force k u + offset, and the events that end it.

    An event is a pair: a function of u and u̇ that becomes positive at the event, and a function of u that returns the
    next piece.
    """

    stiffness: float
    offset: float
    events: tuple[tuple[Callable[[float, float], float], Callable[[float], "_Piece"]], ...]


def _elastic(spring: Elastoplastic, plastic: float) -> _Piece:
    k, b, bound = float(spring.stiffness), float(spring.hardening), float(spring.yield_force / spring.stiffness)
    return _Piece(
        k,
        -(1 - b) * k * plastic,
        (
            (lambda u, v: u - plastic - bound, lambda u: _plastic(spring, 1)),
            (lambda u, v: plastic - u - bound, lambda u: _plastic(spring, -1)),
        ),
    )


def _plastic(spring: Elastoplastic, sign: int) -> _Piece:
    k, b, bound = float(spring.stiffness), float(spring.hardening), float(spring.yield_force / spring.stiffness)
    reversal = (lambda u, v: -sign * v, lambda u: _elastic(spring, u - sign * bound))
    return _Piece(b * k, (1 - b) * k * sign * bound, (reversal,))


def _open(spring: Gap) -> _Piece:
    opening = float(spring.opening)
    return _Piece(0.0, 0.0, ((lambda u, v: u - opening, lambda u: _closed(spring)),))


def _closed(spring: Gap) -> _Piece:
    k, opening = float(spring.stiffness), float(spring.opening)
    return _Piece(k, -k * opening, ((lambda u, v: opening - u, lambda u: _open(spring)),))


def _first_piece(problem: Problem) -> _Piece:
    spring, u0 = problem.force, float(problem.u0)
    if isinstance(spring, Elastoplastic):
        plastic, bound = float(problem.history), float(spring.yield_force / spring.stiffness)
        if abs(u0 - plastic) > bound:
            # the initial force follows from a monotonic motion to u0
            sign = 1 if u0 > plastic else -1
            return _plastic(spring, sign) if sign * float(problem.v0) > 0 else _elastic(spring, u0 - sign * bound)
        return _elastic(spring, plastic)
    if isinstance(spring, Gap):
        return _closed(spring) if u0 > float(spring.opening) else _open(spring)
    raise ValueError(f"the spring of '{problem.title}' is not linear in pieces: {spring!r}.")


def _generator(mass: float, damping: float, stiffness: float) -> np.ndarray:
    """Matrix (4, 4) of the linear equation of (u, u̇, q, q̇), with q = f(t) − offset of the piece, linear in time."""
    return np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiffness / mass, -damping / mass, 1 / mass, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 0.0],
        ]
    )


@lru_cache(maxsize=4096)
def _transition(mass: float, damping: float, stiffness: float, duration: float) -> np.ndarray:
    """Matrix (4, 4) that advances (u, u̇, q, q̇) by a duration; cached, because most intervals of a record are equal."""
    return scipy.linalg.expm(duration * _generator(mass, damping, stiffness))


def trajectory(problem: Problem, t: Times, places: int = PLACES) -> Solution:
    """Displacement and velocity at the increasing times ``t``, exact up to round-off.

    Parameters
    ----------
    problem
        One unknown on a spring of :mod:`study.materials` that is linear in pieces. Its load, if it has one, is linear
        between its ``kinks``.
    t
        Times in seconds.
    places
        Number of instants in the shortest period of the spring at which events are sought.

    Returns
    -------
    Solution
        The motion; ``evaluations`` is the number of pieces.

    Raises
    ------
    ValueError
        If the problem has several unknowns, a spring of another kind or a load without ``kinks``.
    RouteFailed
        If there are more than a million events.
    """
    if np.ndim(problem.u0):
        raise ValueError(f"'{problem.title}' has {len(problem.u0)} unknowns; exact pieces need one.")
    if problem.load is not None and not hasattr(problem.load, "kinks"):
        raise ValueError(f"exact pieces need the kinks of the load of '{problem.title}', between which it is linear.")
    begin = time.perf_counter()
    mass = 1.0 if problem.mass is None else float(problem.mass)
    damping = 0.0 if problem.damping is None else float(problem.damping)
    kinks: np.ndarray = np.array([]) if problem.load is None else np.asarray(problem.load.kinks, float)  # type: ignore[attr-defined]
    stops = np.union1d(np.asarray(t, float), [kink for kink in kinks if 0 < kink < t[-1]])
    piece, now, y = _first_piece(problem), 0.0, np.array([float(problem.u0), float(problem.v0)])
    begins = np.append(0.0, stops)
    loads, middles = np.zeros(len(begins)), np.zeros(len(stops))
    if problem.load is not None:
        load = jax.jit(jax.vmap(problem.load))
        loads, middles = np.asarray(load(begins)), np.asarray(load((begins[1:] + begins[:-1]) / 2))
    spacing = 2 * np.pi * np.sqrt(mass / float(problem.force.stiffness)) / places  # type: ignore[attr-defined]
    states, pieces = {}, 1
    for stop, f0, middle in zip(stops, loads[:-1].tolist(), middles.tolist(), strict=True):
        # the slope of the load follows from its value in the middle of the interval, because the load may jump at the
        # end of a record that does not end in zero
        slope = 2 * (middle - f0) / (stop - now) if stop > now else 0.0
        while now < stop:
            passed, y, piece = _to_event((mass, damping), piece, y, (f0, slope), stop - now, spacing)
            now, f0 = (stop, f0) if passed is None else (now + passed, f0 + slope * passed)
            pieces += passed is not None
            if pieces > MOST_EVENTS:
                raise RouteFailed(f"the motion of '{problem.title}' has more than {MOST_EVENTS} events.")
        states[stop] = y
    u, v = np.array([states[instant] for instant in np.asarray(t, float)]).T
    return Solution(u, v, pieces, time.perf_counter() - begin)


def _to_event(terms: tuple[float, float], piece: _Piece, y: np.ndarray, load: tuple[float, float], duration, spacing):
    """Time to the first event within a duration, or None; the state at that time or the end; the piece that follows."""
    begin = np.array([*y, load[0] - piece.offset, load[1]])
    generator = _generator(*terms, piece.stiffness)

    def motion(tau):
        return (scipy.linalg.expm(tau * generator) @ begin)[:2]

    count = max(int(np.ceil(duration / spacing)), 1)
    step, state = _transition(*terms, piece.stiffness, duration / count), begin
    scale = np.abs(y).max() or 1.0
    for i in range(count):
        state = step @ state
        for event, following in piece.events:
            if event(*state[:2]) <= ROUND_OFF * scale:
                continue
            places = i * duration / count, (i + 1) * duration / count

            def value(tau, event=event):
                return event(*motion(tau))

            # right after an event its function may be above zero by round-off
            tau = scipy.optimize.brentq(value, *places, xtol=1e-300, rtol=1e-15) if value(places[0]) < 0 else places[0]
            return tau, motion(tau), following(motion(tau)[0])
    return None, state[:2], piece
