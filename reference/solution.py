"""What every route returns, what it refuses, and how a period is asked for."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from study.algebra.matrices import Banded, dense, times
from study.problem.definition import Problem

#: Absolute tolerances stand this far below the relative one; displacements and velocities are of order one and more.
ATOL_BELOW_RTOL = 1e-2


class Solution(NamedTuple):
    """Displacement and velocity at the times that were asked for, and what they took.

    ``evaluations`` counts evaluations of the right side (for the Taylor method: of Taylor coefficients);
    ``seconds`` is the run time without compilation.
    """

    u: np.ndarray
    v: np.ndarray
    evaluations: int
    seconds: float


class RouteFailed(RuntimeError):
    """A route did not get where it was asked to go; the message names the route and the reason."""


class StepLimit(RouteFailed):
    """A route took all the steps that it was allowed."""


def check_tolerance(route: str, rtol: float, smallest: float) -> None:
    """Refuse a tolerance that a route cannot reach, before it tries."""
    if not rtol < 1:
        raise ValueError(f"{route} needs a tolerance less than 1, not {rtol:g}.")
    if rtol < smallest:
        raise ValueError(f"{route} cannot reach a tolerance of {rtol:g}; ask for {smallest:g} or more.")


def check_trajectory(route: str, problem: Problem, t: Sequence | np.ndarray, unknowns: float = 1) -> None:
    """Refuse a problem with more unknowns than a route can take, and times that do not increase from zero on."""
    if np.ndim(problem.u0) and unknowns == 1:
        raise ValueError(f"'{problem.title}' has {len(problem.u0)} unknowns; {route} takes one.")
    if problem.massless:
        raise ValueError(f"the mass of '{problem.title}' is singular, which {route} cannot take.")
    finite = len(t) > 0 and all(np.isfinite(float(time)) for time in t)
    if not finite or t[0] < 0 or any(later <= time for time, later in pairwise(t)):
        raise ValueError(f"{route} needs times that are finite and increase from zero on, not {list(map(float, t))}.")


def right_side(t, y, problem: Problem):
    """(u̇, M⁻¹ (f(t) − C u̇ − p(u))) of y = (u, u̇), shape (2, ...), for a solver of first order equations."""
    u, v = y
    force = -problem.force(u)
    if problem.damping is not None:
        force -= times(problem.damping, v)
    if problem.load is not None:
        force += problem.load(t)
    if problem.mass is not None and not isinstance(problem.mass, Banded) and jnp.ndim(problem.mass) < 2:
        force /= problem.mass
    elif problem.mass is not None:
        force = jnp.linalg.solve(dense(problem.mass, u.size), force)
    return jnp.stack([v, force])


def release(route: str, problem: Problem, estimate: float) -> float:
    """Sign of the initial acceleration of a free oscillator at rest, whose period is twice the time to v = 0.

    Raises
    ------
    ValueError
        If the problem is not one: moving at the start, damped, loaded, or in balance; or the estimate no time.
    """
    if not (np.isfinite(estimate) and estimate > 0):
        raise ValueError(
            f"{route} needs a rough period of '{problem.title}' that is greater than zero, not {estimate}."
        )
    reasons = {
        "it is damped": problem.damping is not None,
        "it is loaded": problem.load is not None,
        "it has more than one unknown": np.ndim(problem.u0) > 0,
        "it does not start from rest": np.ndim(problem.u0) == 0 and float(problem.v0) != 0.0,
        "it starts in balance": np.ndim(problem.u0) == 0 and float(problem.force(problem.u0)) == 0.0,
    }
    for reason, holds in reasons.items():
        if holds:
            raise ValueError(f"{route} finds no period of '{problem.title}': {reason}.")
    return -np.sign(float(problem.force(problem.u0)))
