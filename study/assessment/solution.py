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
from study.problem.internal_force import switches
from study.scheme.base import Scheme
from study.scheme.bathe import rho_bathe
from study.scheme.newmark import average_acceleration
from study.scheme.remembering import Remembering

#: Relative tolerances of the routes, from the first try to the last.
TOLERANCES = (1e-8, 1e-10, 1e-12, 1e-14)

#: Points in the shortest period of small motions, or of the coarsest step, with which a grid begins.
POINTS = 12

#: Parts of a run in each of which a comparison in the load may get another answer.
SWITCHES = 4096

#: Points between two kinks of the force, at the least: a contact may be far shorter than a period.
POINTS_BETWEEN_KINKS = 10

#: Places in an interval at which its interpolant is compared. Its errors are about s³(1 − s)³ in u and the slope of
#: that in u̇; a single place may lie where the slope is zero.
BETWEEN = (0.25, 0.6)

#: Most parts into which an interval is divided at once, and most grids that are tried.
MOST_PARTS, GRIDS = 16, 6

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
History = Float[np.ndarray, "t *n"]


class DenseSolution(NamedTuple):
    """Displacement and velocity on a grid, interpolated between its points by the quintic through u, u̇ and ü.

    Attributes
    ----------
    t
        Times, among them every kink of the load, and those of the force.
    u, v, a
        Displacement, velocity and acceleration, of shape (t, ...).
    """

    t: Times
    u: History
    v: History
    a: History

    def at(self, times: Times) -> tuple[History, History]:
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


class Kinks(NamedTuple):
    """Times within the run at which a record has a kink, and those at which a comparison in a force or load changes.

    There the load may jump, and a solver starts anew.
    """

    of_load: Times
    of_force: Times


def _solvers():
    """The modules of diffrax and CVODE."""
    try:
        from reference import diffrax, sundials
    except ImportError as error:
        raise NoReference(f"references need the extra 'reference' of this package: {error}.") from None
    return diffrax, sundials


def _methods(problem: Problem, duration: float) -> tuple[str, str]:
    """The methods of diffrax and CVODE: explicit ones, or implicit ones for a stiff problem."""
    found = frequencies(problem)
    stiff = found is not None and found[-1] * duration > STIFF
    return ("Kvaerno5", "BDF") if stiff else ("Dopri8", "Adams")


def _switches_of_load(load: Callable | None, duration: float) -> Times:
    """Times at which a comparison in the program of a load gets another answer; a record declares its kinks itself.

    A solver would step over a load that acts for a moment, and so would its witness.
    """
    from scipy import optimize  # here, because importing it takes a third of the time to import the study

    if load is None or hasattr(load, "kinks"):
        return np.zeros(0)
    at = jax.jit(lambda t: switches(load, t))
    times = np.linspace(0.0, duration, SWITCHES + 1)
    values = np.asarray(jax.lax.map(at, times))
    places = np.argwhere(np.sign(values[1:]) != np.sign(values[:-1]))
    roots = (
        optimize.brentq(lambda t, k=k: float(at(t)[k]), times[i], times[i + 1], xtol=1e-300, rtol=1e-15)
        for i, k in places
        if values[i, k] * values[i + 1, k] <= 0
    )
    return np.unique(np.asarray(list(roots), float))


def kinks_of(problem: Problem, duration: float) -> Kinks:
    """The kinks of load and force; those of the force are found along the motion.

    A force with a history has its kinks where that tells, and they are not looked for.

    Raises
    ------
    NoReference
        If an unknown has no mass, or the packages of the extra ``reference`` are not installed.
    """
    if problem.massless:
        raise NoReference(f"the mass of '{problem.title}' is singular, and no reference takes such a problem.")
    declared, found = np.asarray(getattr(problem.load, "kinks", []), float), _switches_of_load(problem.load, duration)
    of_load, of_force = (times[(times > 0) & (times < duration)] for times in (declared, found))
    if problem.kinked and problem.history is None:
        stops = np.union1d(of_load, of_force)
        along = _solvers()[1].kinks(problem, duration, stops, _methods(problem, duration)[1])
        of_force = np.union1d(of_force, along)
    return Kinks(of_load, of_force)


def grid_of(problem: Problem, duration: float, coarsest: float, kinks: Kinks) -> Times:
    """First times between which the solution is interpolated, with all kinks of load and force."""
    found = frequencies(problem)
    shortest = coarsest
    if found is not None and 0 < found[-1] < np.inf:
        shortest = min(coarsest, 2 * np.pi / found[-1])
    points = int(np.clip(np.ceil(POINTS * duration / shortest), 200, MOST_POINTS))
    return with_kinks(np.linspace(0.0, duration, points + 1), kinks)


def with_kinks(grid: Times, kinks: Kinks) -> Times:
    """The grid with all kinks, and some points between any two of the force.

    A point next to a kink would only make a short step, and is left out.
    """
    all_kinks = np.union1d(*kinks)
    ends = np.concatenate([[-np.inf], all_kinks, [np.inf]])
    after = np.searchsorted(ends, grid)
    beside = np.minimum(grid - ends[after - 1], ends[after] - grid)
    kept = beside > 0.1 * np.minimum(np.diff(grid, prepend=-np.inf), np.diff(grid, append=np.inf))
    kept[[0, -1]] = True
    merged = np.union1d(grid[kept], all_kinks)
    few = np.diff(np.searchsorted(merged, kinks.of_force)) < POINTS_BETWEEN_KINKS
    stretches = np.linspace(kinks.of_force[:-1], kinks.of_force[1:], POINTS_BETWEEN_KINKS + 1)
    return np.union1d(merged, stretches[:, few])


def with_points_between(grid: Times) -> Times:
    """The grid with points in each of its intervals, where the interpolant is far off."""
    return np.append((grid[:-1, None] + np.diff(grid)[:, None] * (0.0, *BETWEEN)).ravel(), grid[-1])


def refined(one: DenseSolution, other: DenseSolution, goal: float) -> Times:
    """The grid of a solution, finer where its interpolant is off by more than a goal, relative to the largest value.

    Parameters
    ----------
    other
        The solution of another route, with points between.
    """
    off = np.zeros(len(one.t) - 1)
    for mine, theirs in zip(one.at(other.t), (other.u, other.v), strict=True):
        apart = np.abs(mine - theirs).reshape(len(other.t), -1).max(axis=1) / (np.abs(theirs).max() or 1.0)
        at, between = np.split(apart[:-1].reshape(len(off), -1), [1], axis=1)
        # what the routes differ by at the points is no fault of the interpolant
        at_ends = np.maximum(at[:, 0], np.append(at[1:, 0], apart[-1]))
        np.maximum(off, between.max(axis=1) - at_ends, out=off)
    if not np.isfinite(off).all():  # a motion without bound, of which others tell
        return one.t
    # the interpolant of u̇ is of fifth order
    parts = np.ceil(np.clip(off / goal, 1.0, None) ** 0.2).astype(int)
    parts = np.minimum(parts, MOST_PARTS)
    if parts.sum() > MOST_POINTS:
        return one.t
    places = np.repeat(np.arange(len(parts)), parts)
    inside = np.arange(len(places)) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(one.t[places] + inside * (np.diff(one.t) / parts)[places], one.t[-1])


class Route(NamedTuple):
    """A way to the solution: its name, and displacement and velocity at increasing times for a tolerance.

    A third part of the trajectory is the acceleration, where it does not follow from the other two.
    """

    name: str
    trajectory: Callable[[Problem, Times, float], tuple[History, ...]]


def routes_of(problem: Problem, duration: float, kinks: Kinks) -> tuple[Route, Route]:
    """The two routes for a problem, the more accurate one first.

    The Taylor method of heyoka takes a free oscillator whose force translates. Otherwise diffrax and CVODE solve the
    problem: Dopri8 and Adams' method, or, where it is stiff, Kvaerno5 and BDF. A force with a history is no right side
    of an ordinary differential equation; two schemes of the study with many small steps solve such a problem.

    Raises
    ------
    NoReference
        If the packages of the extra ``reference`` are not installed.
    """
    if problem.history is not None:
        return Route("ρ∞-Bathe, small steps", partial(_by_small_steps, rho_bathe)), Route(
            "average acceleration, small steps", partial(_by_small_steps, average_acceleration)
        )
    diffrax, sundials = _solvers()
    one_step, several_steps = _methods(problem, duration)

    def by_diffrax(problem, t, rtol):
        return diffrax.trajectory(problem, t, rtol, one_step, MAX_STEPS)[:2]

    def by_cvode(problem, t, rtol):
        return sundials.trajectory(problem, t, rtol, several_steps, MAX_STEPS, *kinks)[:2]

    of_diffrax = Route(f"diffrax {one_step}", by_diffrax)
    of_cvode = Route(f"CVODE {several_steps}", by_cvode)
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


def solution_by(route: Route, problem: Problem, t: Times, rtol: float) -> DenseSolution:
    """The solution of a route on a grid that begins at zero."""
    u, v, *known = route.trajectory(problem, t[1:], rtol)
    u = np.concatenate([np.asarray(problem.u0, float)[None], u])
    v = np.concatenate([np.asarray(problem.v0, float)[None], v])
    if known:
        return DenseSolution(
            t, u, v, np.concatenate([np.asarray(acceleration(problem, 0.0, u[0], v[0]))[None], *known])
        )
    return DenseSolution(t, u, v, np.asarray(_accelerations(problem, jnp.asarray(t), jnp.asarray(u), jnp.asarray(v))))


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


def _by_small_steps(scheme: Scheme, problem: Problem, t: Times, rtol: float) -> tuple[History, ...]:
    """The motion with steps whose number grows as the fourth root of the tolerance falls, from the grid's own on."""
    parts = jnp.asarray(round(STEPS_PER_POINT * (TOLERANCES[0] / rtol) ** 0.25))
    return tuple(map(np.asarray, _marched(Remembering(scheme), problem.untitled(), jnp.append(0.0, t), parts)))
