"""The reference solution of a problem by two independent solvers, on grids with all kinks of load and force."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.jit import jit
from study.assessment.solution import MOST_POINTS, DenseSolution, History, Times, with_points_between
from study.mechanics.balance import acceleration
from study.mechanics.definition import Problem
from study.mechanics.frequencies import frequencies
from study.mechanics.loads import times_of_problem

#: Number of points of the first grid in the shortest period of small motions or in the coarsest step, whichever is
#: shorter.
POINTS = 12

#: Number of intervals of the scan of a load, a prime number. It is finer than before a run, which takes less time.
FINE = 131_071

#: Least number of intervals between two kinks of the force, because a contact may be far shorter than a period.
POINTS_BETWEEN_KINKS = 10

#: Largest number of successively refined grids.
GRIDS = 6

#: Largest product of the highest circular frequency and the duration for which a problem is not stiff. Above it,
#: explicit solvers would need too many steps.
STIFF = 2e6

#: Largest number of steps of a solver.
MAX_STEPS = 4_000_000


class NoReference(ValueError):
    """The solvers give no reference that is accurate enough; the message states why."""


class Kinks(NamedTuple):
    """Times within the duration at which the acceleration has kinks or jumps.

    ``load`` are the kinks that a load declares, such as the samples of a record. ``force`` are the kinks of a
    force, and the times that a scan of the load found (:func:`study.mechanics.scan.events`). There the load may jump,
    so a solver restarts.
    """

    load: Times
    force: Times


class Route(NamedTuple):
    """One way to the reference: the name of a solver, and a function that returns u and u̇ at times, to a tolerance."""

    name: str
    trajectory: Callable[[Times, float], tuple[History, History]]


def _sundials():
    """The module of CVODE."""
    try:
        from reference import sundials
    except ImportError as error:
        raise NoReference(f"references need the extra 'reference' of this package: {error}.") from None
    return sundials


@partial(jit, compiler=eqx.filter_jit)
def _accelerations(problem: Problem, t, u, v):
    def advance(history, state):
        committed = problem.remembering(history).at_time(state[0]).committed(*state[1:])
        return committed.history, acceleration(committed, *state)

    return jax.lax.scan(advance, problem.history, (t, u, v))[1]


class Reference:
    """The kinks of a problem over a duration, its grid, and the two routes, which are solvers with their settings.

    The first route is the Taylor method of heyoka, if the problem has one unknown and its force and load can be
    translated. Otherwise it is diffrax, with Dopri8 or, for a stiff problem, Kvaerno5. The second route is CVODE, with
    Adams' method or, for a stiff problem, BDF. No route shares code with a scheme.

    The history of a force is updated at the times of the grid. Between two of these times the force is a function of u
    and u̇. This is exact as long as no element reverses in between, so every reversal is a kink of the grid. The routes
    agree only if this holds.

    Parameters
    ----------
    problem
        The problem.
    duration
        Duration of the motion in s.

    Attributes
    ----------
    kinks
        The kinks of load and force. Kinks of the force are found along the motion.
    routes
        The two routes, the more accurate route first.

    Raises
    ------
    NoReference
        If an unknown has no mass, the motion stays at a jump of the force, or the packages of the extra ``reference``
        are not installed.
    """

    def __init__(self, problem: Problem, duration: float):
        if problem.massless:
            raise NoReference(f"the mass of '{problem.title}' is singular, and no reference solves such a problem.")
        self.problem, self.duration = problem, duration
        values = frequencies(problem)
        self._highest = None if values is None else values[-1]
        stiff = values is not None and values[-1] * duration > STIFF
        self._methods = ("Kvaerno5", "BDF") if stiff else ("Dopri8", "Adams")
        self.kinks = self._kinks()
        self.routes = self._routes()

    def _kinks(self) -> Kinks:
        load, end = self.problem.load, self.duration
        declared = np.asarray(getattr(load, "kinks", []), float)
        load_kinks = declared[(declared > 0) & (declared < end)]
        force_kinks = np.setdiff1d(times_of_problem(self.problem, end, FINE), load_kinks)
        if self.problem.has_kinks:
            stops = np.union1d(load_kinks, force_kinks)
            sundials = _sundials()
            try:
                motion_kinks = sundials.kinks(self.problem, end, stops, self._methods[1])
            except sundials.Sticking as error:
                raise NoReference(
                    f"no reference of '{self.problem.title}' was found, because {error}: where dry friction sticks, "
                    "its force must be a function of the displacement, as study.materials.friction is."
                ) from None
            force_kinks = np.union1d(force_kinks, motion_kinks)
        return Kinks(load_kinks, force_kinks)

    def _routes(self) -> tuple[Route, Route]:
        sundials = _sundials()
        problem, (one_step, several_steps) = self.problem, self._methods

        def by_diffrax(t, rtol):
            from reference import diffrax  # imported here, because the route through heyoka does not need it

            return diffrax.trajectory(problem, t, rtol, one_step, MAX_STEPS)[:2]

        def by_cvode(t, rtol):
            return sundials.trajectory(problem, t, rtol, several_steps, MAX_STEPS, *self.kinks)[:2]

        diffrax_route = Route(f"diffrax {one_step}", by_diffrax)
        cvode_route = Route(f"CVODE {several_steps}", by_cvode)
        # the steps of the Taylor method end at no given times, so they could pass over a pulse
        if np.ndim(problem.u0) or len(np.union1d(*self.kinks)):
            return diffrax_route, cvode_route
        from reference import symbolic, taylor  # imported here, because the import takes a second

        def by_taylor(t, rtol):
            return taylor.trajectory(problem, t, max(rtol * 1e-2, np.finfo(float).eps))[:2]

        try:
            symbolic.first_order(problem)
        except symbolic.Untranslatable:
            return diffrax_route, cvode_route
        return Route("heyoka", by_taylor), cvode_route

    def grid(self, coarsest: float) -> Times:
        """The first grid: times between which the solution is interpolated, including all kinks of load and force."""
        shortest = coarsest
        if self._highest is not None and 0 < self._highest < np.inf:
            shortest = min(coarsest, 2 * np.pi / self._highest)
        points = int(np.clip(np.ceil(POINTS * self.duration / shortest), 200, MOST_POINTS))
        return self.with_kinks(np.linspace(0.0, self.duration, points + 1))

    def with_kinks(self, grid: Times) -> Times:
        """The grid with all kinks, and at least ``POINTS_BETWEEN_KINKS`` intervals between two kinks of the force.

        Points of the grid close to a kink are left out, because they would only cause short steps.
        """
        force_kinks, all_kinks = self.kinks.force, np.union1d(*self.kinks)
        ends = np.concatenate([[-np.inf], all_kinks, [np.inf]])
        after = np.searchsorted(ends, grid)
        distance = np.minimum(grid - ends[after - 1], ends[after] - grid)
        apart = distance > 0.1 * np.minimum(np.diff(grid, prepend=-np.inf), np.diff(grid, append=np.inf))
        apart[[0, -1]] = True
        merged = np.union1d(grid[apart], all_kinks)
        sparse = np.diff(np.searchsorted(merged, force_kinks)) < POINTS_BETWEEN_KINKS
        stretches = np.linspace(force_kinks[:-1], force_kinks[1:], POINTS_BETWEEN_KINKS + 1)
        return np.union1d(merged, stretches[:, sparse])

    def solution(self, route: Route, t: Times, rtol: float) -> DenseSolution:
        """The solution of a route on a grid that begins at t = 0."""
        u, v = route.trajectory(t[1:], rtol)
        u = np.concatenate([np.asarray(self.problem.u0, float)[None], u])
        v = np.concatenate([np.asarray(self.problem.v0, float)[None], v])
        return DenseSolution(t, u, v, np.asarray(_accelerations(self.problem, *map(jnp.asarray, (t, u, v)))))

    def refined(self, grid: Times, rtol: float, goal: float) -> Times:
        """The grid, refined until the interpolant of the first route reaches the goal, without the second route."""
        for _ in range(GRIDS):
            first, closer = (self.solution(self.routes[0], t, rtol) for t in (grid, with_points_between(grid)))
            finer = first.refined(closer, goal)
            if len(finer) == len(grid):
                break
            grid = finer
        return grid

    def solutions(self, grid: Times, rtol: float, goal: float) -> tuple[DenseSolution, DenseSolution, Times]:
        """Solutions of both routes, and their grid, refined until the interpolant of the first reaches the goal.

        The second solution also has points between the points of the first, so that the difference of the two
        solutions shows the error of the interpolant. At most ``GRIDS`` grids are tried. If the last one misses the
        goal, its refinement is returned as the grid. A grid with too many points is not refined.

        Parameters
        ----------
        grid
            Grid of the first try.
        goal
            Target error of the interpolant, relative to the largest value.
        """
        for _ in range(GRIDS):
            first = self.solution(self.routes[0], grid, rtol)
            second = self.solution(self.routes[1], with_points_between(grid), rtol)
            finer = first.refined(second, goal)
            if len(finer) == len(grid):
                break
            grid = finer
        return first, second, grid
