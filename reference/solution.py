"""Common parts of the routes: their solution, their exceptions, and their checks of problem and times."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from study.algebra.elimination import solve
from study.algebra.matrices import Banded, dense, times
from study.algebra.sparse import Sparse
from study.mechanics.definition import Problem

#: Ratio of absolute to relative tolerance, for displacements and velocities of order one or more.
ATOL_BELOW_RTOL = 1e-2

#: Times in seconds.
Times = Float[np.ndarray, "t"]
#: Displacements or velocities along time; a problem with one unknown has no axis n.
History = Float[np.ndarray, "t *n"]
#: Array with one value for each window of time.
Windowed = Float[np.ndarray, "windows"]
#: Displacement and velocity together.
State = Float[Array, "2 *n"]


class Solution(NamedTuple):
    """Solution of a route at the requested times, with its effort.

    Attributes
    ----------
    u, v
        Displacement and velocity.
    evaluations
        Number of evaluations of the right side. For diffrax's implicit method it is the number of stages, for the
        Taylor method the number of Taylor coefficients, and for exact pieces the number of pieces. It is −1 for
        OpenSees, which does not count evaluations.
    seconds
        Run time in s, for diffrax and heyoka without compilation.
    """

    u: History
    v: History
    evaluations: int
    seconds: float


class RouteFailed(RuntimeError):
    """A route finds no certain solution; the message states the reason."""


class StepLimit(RouteFailed):
    """A route stopped at its limit of steps."""


def check_tolerance(route: str, rtol: float, smallest: float) -> None:
    """Refuse a relative tolerance that a route cannot reach.

    Raises
    ------
    ValueError
        If the tolerance is 1 or more, or smaller than ``smallest``.
    """
    if not rtol < 1:
        raise ValueError(f"{route} needs a tolerance less than 1, not {rtol:g}.")
    if rtol < smallest:
        raise ValueError(f"{route} cannot reach a tolerance of {rtol:g}; ask for {smallest:g} or more.")


def check_trajectory(route: str, problem: Problem, t: Sequence | np.ndarray, unknowns: float = 1) -> None:
    """Refuse a problem that a route cannot solve, and times that do not increase from zero on.

    Raises
    ------
    ValueError
        If the problem has several unknowns but the route takes one (``unknowns=1``), if its mass is singular, or if
        the times are empty, negative, not finite or not strictly increasing.
    """
    if np.ndim(problem.u0) and unknowns == 1:
        raise ValueError(f"'{problem.title}' has {len(problem.u0)} unknowns; {route} takes one.")
    if problem.massless:
        raise ValueError(f"the mass of '{problem.title}' is singular, which {route} cannot solve.")
    finite = len(t) > 0 and all(np.isfinite(float(time)) for time in t)
    if not finite or t[0] < 0 or any(later <= time for time, later in pairwise(t)):
        raise ValueError(f"{route} needs times that are finite and increase from zero on, not {list(map(float, t))}.")


def right_side(t, y: State, problem: Problem) -> State:
    """Right side of the first order equations of y = (u, u̇): ẏ = (u̇, M⁻¹ (f(t) − C u̇ − p(u)))."""
    u, v = y
    force = -problem.at_time(t).internal_force(u, v)
    if problem.damping is not None:
        force -= times(problem.damping, v)
    if problem.load is not None:
        force += problem.load(t)
    if isinstance(problem.mass, Sparse):
        force = solve(problem.mass, force)
    elif problem.mass is not None and not isinstance(problem.mass, Banded) and jnp.ndim(problem.mass) < 2:
        force /= problem.mass
    elif problem.mass is not None:
        force = jnp.linalg.solve(dense(problem.mass, u.size), force)
    return jnp.stack([v, force])


def release(route: str, problem: Problem, estimate: float) -> float:
    """Sign of the initial acceleration of a free oscillator that starts at rest.

    The period of such an oscillator is twice the time to its next turning point.

    Raises
    ------
    ValueError
        If the problem is damped or loaded, has several unknowns, moves at the start, or starts in equilibrium, or if
        the estimate of its period is not a finite time greater than zero.
    """
    if not (np.isfinite(estimate) and estimate > 0):
        raise ValueError(
            f"{route} needs a rough period of '{problem.title}' that is greater than zero, not {estimate}."
        )
    initial = problem.at_time(0.0)
    reasons = {
        "it is damped": problem.damping is not None,
        "it is loaded": problem.load is not None,
        "its force takes the time": problem.takes_time,
        "it has more than one unknown": np.ndim(problem.u0) > 0,
        "it does not start from rest": np.ndim(problem.u0) == 0 and float(problem.v0) != 0.0,
        "it starts in equilibrium": np.ndim(problem.u0) == 0 and float(initial.static_force(problem.u0)) == 0.0,
    }
    for reason, holds in reasons.items():
        if holds:
            raise ValueError(f"{route} finds no period of '{problem.title}': {reason}.")
    return -np.sign(float(initial.static_force(problem.u0)))
