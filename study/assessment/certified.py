"""The certified reference of a problem: two routes that share nothing, tightened until they agree."""

from typing import NamedTuple

import numpy as np

from study.assessment import errors, ladder, oscillation, solution
from study.assessment.errors import Target
from study.assessment.ladder import Case
from study.assessment.oscillation import Oscillation
from study.assessment.solution import DenseSolution, NoReference, Route
from study.observer.motion import Quantity
from study.problem.definition import Problem
from study.problem.loads import excited

#: Uncertainty of the reference that is aimed at, as a part of the smallest error asked for, and the most that is taken.
AIMED, ACCEPTED = 1 / 100, 1 / 10

#: Error of the interpolant that is aimed at on a free oscillator of one unknown, where points are cheap.
OF_FREE_OSCILLATOR = 1e-8

#: Least part of the duration that a reference must hold.
SHORTEST = 0.05


class Reference(NamedTuple):
    """The solution, what it says, how far it is to be trusted, and until when."""

    solution: DenseSolution
    targets: dict[str, Target]
    oscillation: Oscillation | None
    uncertainty: dict[str, float]
    route: Route
    witness: Route
    rtol: float
    horizon: float


def _holds(
    one: DenseSolution, other: DenseSolution, quantities: dict[str, Quantity], problem: Problem, most: float
) -> float:
    """Time of the first solution up to which two agree in every quantity."""
    ends = [one.t[-1]]
    for quantity in quantities.values():
        _, along = errors.difference(quantity, problem, one, other)
        apart = other.t[~(along <= most)]
        ends += [one.t[np.searchsorted(one.t, apart[0], side="right") - 1]] if apart.size else []
    return float(min(ends))


def _on_a_grid(
    problem: Problem, routes: tuple[Route, Route], grid: solution.Times, rtol: float, tightest: float
) -> tuple[DenseSolution, DenseSolution, solution.Times]:
    """Solutions of both routes, and a grid fine enough for the interpolant of the first one.

    The second solution has points between any two of the first, so that their difference tells of the interpolant.
    """
    free = not np.ndim(problem.u0) and problem.conservative
    goal = min(AIMED * tightest, OF_FREE_OSCILLATOR) if free else AIMED * tightest
    for _ in range(solution.GRIDS):
        one = solution.solution_by(routes[0], problem, grid, rtol)
        other = solution.solution_by(routes[1], problem, solution.with_points_between(grid), rtol)
        finer = solution.refined(one, other, goal)
        if len(finer) == len(grid):
            break
        grid = finer
    return one, other, grid


def certified(
    problem: Problem,
    duration: float,
    quantities: dict[str, Quantity],
    tightest: float,
    coarsest: float,
    periodic: bool,
) -> Reference:
    """The reference, from two routes whose tolerance is tightened until they agree.

    Raises
    ------
    NoReference
        If the routes fail, or agree over a small part of the duration only.
    ValueError
        If the problem has no motion.
    """
    kinks = solution.kinks_of(problem, duration)
    route, witness = solution.routes_of(problem, duration, kinks)
    grid = solution.grid_of(problem, duration, coarsest, kinks)
    reached: tuple | None = None
    for rtol in solution.TOLERANCES:
        try:
            one, other, grid = _on_a_grid(problem, (route, witness), grid, rtol, tightest)
        except (ValueError, RuntimeError) as error:
            if reached is None:
                raise NoReference(f"no reference of '{problem.title}' was found: {error}") from error
            break
        apart = {name: errors.difference(q, problem, one, other)[0] for name, q in quantities.items()}
        if reached is None or max(apart.values()) < max(reached[2].values()):
            reached = one, other, apart, rtol
        if max(apart.values()) <= AIMED * tightest:
            break
    assert reached is not None
    one, other, apart, rtol = reached
    if not np.any(one.u != one.u[0]) and not np.any(one.v):
        raise ValueError(f"'{problem.title}' does not move: give it a start away from balance, or a load.")
    horizon = duration
    if max(apart.values()) > ACCEPTED * tightest:
        horizon = _holds(one, other, quantities, problem, AIMED * tightest)
        if horizon < SHORTEST * duration:
            raise NoReference(
                f"{route.name} and {witness.name} differ by {max(apart.values()):.1e} on '{problem.title}' at a "
                f"tolerance of {rtol:g}, and agree to {AIMED * tightest:.1e} only up to t = {horizon:.4g}: allow a "
                "larger error or a shorter duration."
            )
        one, other = (_until(s, horizon) for s in (one, other))
        apart = {name: errors.difference(q, problem, one, other)[0] for name, q in quantities.items()}
    targets = {name: errors.target(q, problem, one) for name, q in quantities.items()}
    swing, of_witness = (oscillation.oscillation(problem, s) if periodic else None for s in (one, other))
    if swing is not None and of_witness is not None:
        apart |= oscillation.uncertainties(swing, of_witness, max(apart.values()))
    return Reference(one, targets, swing, apart, route, witness, rtol, horizon)


def _until(whole: DenseSolution, end: float) -> DenseSolution:
    """A solution up to a time of its grid."""
    count = int(np.searchsorted(whole.t, end, side="right"))
    return DenseSolution(*(part[:count] for part in whole))


def cases_of(
    problem: Problem, reference: Reference, quantities: dict[str, Quantity], tightest: float
) -> dict[float, Case]:
    """The problem and its neighbours, each with its own reference.

    Raises
    ------
    NoReference
        If the routes fail for a neighbour.
    """
    cases = {1.0: Case(problem, reference.solution, reference.targets, reference.oscillation)}
    for factor in ladder.STARTS:
        neighbour = excited(problem, factor, displaced=True)
        kinks = solution.kinks_of(neighbour, reference.horizon)
        routes = solution.routes_of(neighbour, reference.horizon, kinks)
        # its kinks have times of their own, and so has what is fast in its motion
        grid = solution.with_kinks(reference.solution.t, kinks) if problem.kinked else reference.solution.t
        try:
            one, *_ = _on_a_grid(neighbour, routes, grid, reference.rtol, tightest)
        except (ValueError, RuntimeError) as error:
            raise NoReference(
                f"no reference of a start one percent from that of '{problem.title}' was found: {error}"
            ) from error
        targets = {name: errors.target(quantity, neighbour, one) for name, quantity in quantities.items()}
        swing = oscillation.oscillation(neighbour, one) if reference.oscillation else None
        cases[factor] = Case(neighbour, one, targets, swing)
    return cases
