"""The certified reference of a problem, by two solvers whose tolerance is tightened until they agree."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from study.assessment import errors, oscillation, search
from study.assessment.errors import Target
from study.assessment.oscillation import Oscillation
from study.assessment.reference import FINE, NoReference, Reference, Route
from study.assessment.search import Case
from study.assessment.solution import DenseSolution
from study.mechanics.definition import Problem
from study.mechanics.loads import excited, times_of
from study.observer.motion import Quantity
from study.warn import warn

#: Target and maximum of the uncertainty of the reference, as fractions of the smallest allowed error.
AIMED, ACCEPTED = 1 / 100, 1 / 10

#: Relative tolerances of the two solvers, from the first try to the last.
TOLERANCES = (1e-8, 1e-10, 1e-12, 1e-14)

#: Ratio of the difference of the solutions right after they part to the one at which they part, above which they part
#: suddenly: where a motion is chaotic, their difference grows by a small factor from one point of the grid to the next.
SUDDEN = 100

#: Advice for a load whose kinks are found by a scan only.
KINKS = "give the load an attribute kinks with the times at which it or its slope jumps"

#: Smallest fraction of the duration over which the two solutions must agree.
SHORTEST = 0.05


class Certified(NamedTuple):
    """The reference solution, its quantities, their uncertainty, and the time ``horizon`` up to which it holds."""

    solution: DenseSolution
    targets: dict[str, Target]
    oscillation: Oscillation | None
    uncertainty: dict[str, float]
    route: Route
    witness: Route
    rtol: float
    horizon: float


def undeclared(load: Callable | None) -> bool:
    """Whether there is a load that declares no kinks."""
    return load is not None and not np.size(getattr(load, "kinks", ()))


def _holds(
    first: DenseSolution, second: DenseSolution, quantities: dict[str, Quantity], problem: Problem, most: float
) -> float:
    """Last time on the grid of ``first`` that is not after the first difference above ``most`` in any quantity."""
    ends = [first.t[-1]]
    for quantity in quantities.values():
        _, along = errors.difference(quantity, problem, first, second)
        times = second.t[~(along <= most)]
        ends += [first.t[np.searchsorted(first.t, times[0], side="right") - 1]] if times.size else []
    return float(min(ends))


def _suddenly(
    first: DenseSolution, second: DenseSolution, quantities: dict[str, Quantity], problem: Problem, horizon: float
) -> float:
    """Largest difference in any quantity up to two points of the grid of ``first`` after a time."""
    end = first.t[min(int(np.searchsorted(first.t, horizon)) + 2, len(first.t) - 1)]
    along = (errors.difference(quantity, problem, first, second)[1] for quantity in quantities.values())
    return float(max(difference[second.t <= end].max() for difference in along))


def _check_shortest(reference: Reference) -> None:
    """Warn if the load has a pulse that the scan can only find by a number of the program."""
    load, duration = reference.problem.load, reference.duration
    if not undeclared(load):
        return
    gaps = np.diff(times_of(load, duration, FINE))
    if gaps.size and (shortest := gaps.min()) < duration / FINE:
        warn(
            f"the load of '{reference.problem.title}' has a pulse of about {shortest:.1g} s; another one shorter "
            f"than {2 * duration / FINE:.1g} s may have been missed: {KINKS}."
        )


def certified(
    problem: Problem,
    duration: float,
    quantities: dict[str, Quantity],
    tightest: float,
    coarsest: float,
    periodic: bool,
) -> Certified:
    """The reference, from two solvers whose tolerance is tightened until they agree.

    Raises
    ------
    NoReference
        If the solvers fail at the loosest tolerance, or agree only over less than a twentieth of the duration; also as
        :class:`Reference`.
    ValueError
        If the problem does not move, or a quantity is not finite or is zero at all times.
    """
    reference = Reference(problem, duration)
    _check_shortest(reference)
    (route, witness), grid = reference.routes, reference.grid(coarsest)
    best: tuple | None = None
    for rtol in TOLERANCES:
        try:
            solution, comparison, grid = reference.solutions(grid, rtol, AIMED * tightest)
        except (ValueError, RuntimeError) as error:
            if best is None:
                raise NoReference(
                    f"no reference was found: {str(error).rstrip('.')}; try a shorter duration."
                ) from error
            break
        differences = {name: errors.difference(q, problem, solution, comparison)[0] for name, q in quantities.items()}
        if best is None or max(differences.values()) < max(best[2].values()):
            best = solution, comparison, differences, rtol
        if max(differences.values()) <= AIMED * tightest:
            break
    assert best is not None
    solution, comparison, differences, rtol = best
    if not np.any(solution.u != solution.u[0]) and not np.any(solution.v):
        raise ValueError(f"'{problem.title}' does not move: give it a start away from equilibrium, or a load.")
    horizon = duration
    if max(differences.values()) > ACCEPTED * tightest:
        horizon = _holds(solution, comparison, quantities, problem, AIMED * tightest)
        may_jump = undeclared(problem.load) and not problem.has_kinks
        if may_jump and _suddenly(solution, comparison, quantities, problem, horizon) > SUDDEN * AIMED * tightest:
            raise NoReference(
                f"{route.name} and {witness.name} part suddenly on '{problem.title}' after t = {horizon:.4g}, as at a "
                f"short pulse of the load: {KINKS}."
            )
        if horizon < SHORTEST * duration:
            raise NoReference(
                f"{route.name} and {witness.name} differ by {max(differences.values()):.1e} on '{problem.title}' at a "
                f"tolerance of {rtol:g}, and agree to {AIMED * tightest:.1e} only up to t = {horizon:.4g}: "
                + (f"{KINKS}, or " if undeclared(problem.load) else "")
                + "allow a larger error or a shorter duration."
            )
        solution, comparison = (s.until(horizon) for s in (solution, comparison))
        differences = {name: errors.difference(q, problem, solution, comparison)[0] for name, q in quantities.items()}
    targets = {name: errors.target(q, problem, solution) for name, q in quantities.items()}
    swing, witness_swing = (oscillation.oscillation(problem, s) if periodic else None for s in (solution, comparison))
    if swing is not None and witness_swing is not None:
        differences |= oscillation.uncertainties(swing, witness_swing, max(differences.values()))
    return Certified(solution, targets, swing, differences, route, witness, rtol, horizon)


def cases_of(
    problem: Problem, reference: Certified, quantities: dict[str, Quantity], tightest: float
) -> dict[float, Case]:
    """The problem, and its neighbours with start and load one percent smaller and larger, each with its own reference.

    The keys are the multiples of start and load.

    Raises
    ------
    NoReference
        If the solvers fail for a neighbour.
    """
    cases = {1.0: Case(problem, reference.targets, reference.oscillation)}
    for factor in search.STARTS:
        neighbour = excited(problem, factor, displaced=True)
        nearby, grid = Reference(neighbour, reference.horizon), reference.solution.t
        try:
            if problem.has_kinks:  # the neighbour's kinks are at other times
                solution, *_ = nearby.solutions(nearby.with_kinks(grid), reference.rtol, AIMED * tightest)
            else:
                solution = nearby.solution(nearby.routes[0], grid, reference.rtol)
        except (ValueError, RuntimeError) as error:
            raise NoReference(
                f"no reference was found from a start one percent away: {str(error).rstrip('.')}; "
                "try a shorter duration."
            ) from error
        targets = {name: errors.target(quantity, neighbour, solution) for name, quantity in quantities.items()}
        swing = oscillation.oscillation(neighbour, solution) if reference.oscillation else None
        cases[factor] = Case(neighbour, targets, swing)
    return cases
