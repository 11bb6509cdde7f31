"""The certified solution of a problem: two routes that share nothing, tightened until they agree."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from study.algebra.interpolation import quintic, value
from study.equilibrium.balance import acceleration
from study.problem.definition import Problem
from study.problem.frequencies import frequencies
from study.scheme.base import Scheme
from study.scheme.bathe import rho_bathe
from study.scheme.newmark import average_acceleration
from study.scheme.remembering import Remembering

#: Relative tolerances of the routes, from the first try to the last.
TOLERANCES = (1e-8, 1e-10, 1e-12, 1e-14)

#: Points in the shortest period of small motions, or of the coarsest step, between which the solution is interpolated.
POINTS = 40

#: Most points of a solution.
MOST_POINTS = 200_000

#: Phase in radians of the highest mode over the run from which on explicit routes take too many steps.
STIFF = 2e6

#: Steps between two points of a solution by small steps, at the loosest tolerance.
STEPS_PER_POINT = 10

#: Most steps of a route.
MAX_STEPS = 4_000_000

#: Times in seconds.
Times = Float[np.ndarray, "t"]

#: Displacements or velocities at these times.
Motion = Float[np.ndarray, "t *n"]


class Solution(NamedTuple):
    """Displacement and velocity on a grid, interpolated between its points by the quintic through u, u̇ and ü.

    Attributes
    ----------
    t
        Times, among them every kink of the load.
    u, v, a
        Displacement, velocity and acceleration, of shape (t, ...).
    """

    t: Times
    u: Motion
    v: Motion
    a: Motion

    def at(self, times: Times) -> tuple[Motion, Motion]:
        """Displacement and velocity at any times of the run."""
        i = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        h = self.t[i + 1] - self.t[i]
        s = np.clip((times - self.t[i]) / h, 0.0, 1.0)
        h, s = (x.reshape(-1, *(1,) * (self.u.ndim - 1)) for x in (h, s))
        ends = (self.u[i], self.v[i], self.a[i]), (self.u[i + 1], self.v[i + 1], self.a[i + 1])
        return value(quintic(*ends, h), s), value(quintic(*ends, h, of_v=True), s) / h


class NoReference(ValueError):
    """No route solves the problem accurately enough; the message says how far they got and why."""


@eqx.filter_jit
def _accelerations(problem, t, u, v):
    return jax.lax.map(lambda at: acceleration(problem, *at), (t, u, v))


def kinks_of(problem: Problem, duration: float) -> Times:
    """Times within the run at which the slope of the load jumps."""
    kinks = np.asarray(getattr(problem.load, "kinks", []), float)
    return kinks[(kinks > 0) & (kinks < duration)]


def grid_of(problem: Problem, duration: float, coarsest: float) -> Times:
    """Times between which the solution is interpolated, with all kinks of the load."""
    found = frequencies(problem)
    shortest = coarsest
    if found is not None and 0 < found[-1] < np.inf:
        shortest = min(coarsest, 2 * np.pi / found[-1])
    points = int(np.clip(np.ceil(POINTS * duration / shortest), 200, MOST_POINTS))
    even = np.linspace(0.0, duration, points + 1)
    kinks = kinks_of(problem, duration)
    # a point next to a kink would only make a short step
    ends = np.concatenate([[-np.inf], kinks, [np.inf]])
    after = np.searchsorted(ends, even)
    beside = np.minimum(even - ends[after - 1], ends[after] - even)
    return np.union1d(even[(beside > 0.1 * duration / points) | (even == 0) | (even == duration)], kinks)


class Route(NamedTuple):
    """A way to the solution: its name, and displacement and velocity at increasing times for a tolerance.

    A third part of the trajectory is the acceleration, where it does not follow from the other two.
    """

    name: str
    trajectory: Callable[[Problem, Times, float], tuple[Motion, ...]]


def routes_of(problem: Problem, duration: float) -> tuple[Route, Route]:
    """The two routes for a problem, the more accurate one first.

    The Taylor method of heyoka takes a free oscillator whose force translates. Otherwise diffrax and CVODE solve the
    problem: Dopri8 and Adams' method, or, where it is stiff, Kvaerno5 and BDF. A force with a history is no right side
    of an ordinary differential equation; two schemes of the study with many small steps solve such a problem.

    Raises
    ------
    NoReference
        If an unknown has no mass, or the packages of the extra ``reference`` are not installed.
    """
    if problem.massless:
        raise NoReference(f"the mass of '{problem.title}' is singular, and no reference takes such a problem.")
    if problem.history is not None:
        return Route("ρ∞-Bathe, small steps", partial(_by_small_steps, rho_bathe)), Route(
            "average acceleration, small steps", partial(_by_small_steps, average_acceleration)
        )
    try:
        from reference import diffrax, sundials
    except ImportError as error:
        raise NoReference(f"references need the extra 'reference' of this package: {error}.") from None
    kinks = kinks_of(problem, duration)
    found = frequencies(problem)
    stiff = found is not None and found[-1] * duration > STIFF
    explicit, implicit = ("Kvaerno5", "BDF") if stiff else ("Dopri8", "Adams")

    def by_diffrax(problem, t, rtol):
        return diffrax.trajectory(problem, t, rtol, explicit, MAX_STEPS)[:2]

    def by_cvode(problem, t, rtol):
        return sundials.trajectory(problem, t, rtol, implicit, MAX_STEPS, kinks)[:2]

    of_diffrax = Route(f"diffrax {explicit}", by_diffrax)
    of_cvode = Route(f"CVODE {implicit}", by_cvode)
    if np.ndim(problem.u0) or not problem.conservative:
        return of_diffrax, of_cvode
    from reference import symbolic, taylor  # here, because importing them takes a second

    def by_taylor(problem, t, rtol):
        return taylor.trajectory(problem, t, max(rtol * 1e-2, np.finfo(float).eps))[:2]

    try:
        symbolic.first_order(problem)
    except symbolic.Untranslatable:
        return of_diffrax, of_cvode
    return Route("heyoka", by_taylor), of_diffrax


def solution_by(route: Route, problem: Problem, t: Times, rtol: float) -> Solution:
    """The solution of a route on a grid that begins at zero."""
    u, v, *known = route.trajectory(problem, t[1:], rtol)
    u = np.concatenate([np.asarray(problem.u0, float)[None], u])
    v = np.concatenate([np.asarray(problem.v0, float)[None], v])
    if known:
        return Solution(t, u, v, np.concatenate([np.asarray(acceleration(problem, 0.0, u[0], v[0]))[None], *known]))
    return Solution(t, u, v, np.asarray(_accelerations(problem, jnp.asarray(t), jnp.asarray(u), jnp.asarray(v))))


@eqx.filter_jit
def _marched(scheme: Remembering, problem: Problem, t, parts):
    """Displacement, velocity and acceleration at the times t, with ``parts`` equal steps between two of them."""
    state, _ = scheme.start(problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), t[1])

    def between(state, ends):
        dt = (ends[1] - ends[0]) / parts

        def step(i, state):
            return scheme.step(problem, state, ends[0] + i.astype(float) * dt, dt)[0]

        state = jax.lax.fori_loop(0, parts, step, state)
        return state, (state.u, state.v, acceleration(problem.at(state), ends[1], state.u, state.v))

    return jax.lax.scan(between, state, jnp.stack([t[:-1], t[1:]], axis=1))[1]


def _by_small_steps(scheme: Scheme, problem: Problem, t: Times, rtol: float) -> tuple[Motion, ...]:
    """The motion with steps whose number grows as the fourth root of the tolerance falls, from the grid's own on."""
    parts = jnp.asarray(round(STEPS_PER_POINT * (TOLERANCES[0] / rtol) ** 0.25))
    return tuple(map(np.asarray, _marched(Remembering(scheme), problem.untitled(), jnp.append(0.0, t), parts)))
