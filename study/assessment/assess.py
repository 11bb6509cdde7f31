"""``study.assess``: the whole way from a problem to the scheme and the step that it needs."""

import platform
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from tqdm import tqdm

from study import datasets
from study.assessment import certified, errors, failures, ladder
from study.assessment.certified import NoReference, Route, Solution
from study.assessment.errors import Target
from study.assessment.ladder import ENERGY, Case, Ladder, Verdict
from study.datasets import flags
from study.marching.arguments import resolve
from study.marching.ensemble import cores
from study.marching.timing import Timed
from study.observer.motion import Quantity
from study.problem.definition import Problem
from study.problem.frequencies import frequencies
from study.problem.loads import excited
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.named import schemes as schemes_by_name

#: Schemes that are assessed if none are named: the ones that codes offer, and the best of each family.
USUAL = (
    "average_acceleration",
    "central_difference",
    "newmark_dissipative",
    "wilson_theta",
    "houbolt",
    "hht_alpha_one_force",
    "generalized_alpha",
    "bathe",
    "rho_bathe",
    "rk4",
)

#: Periods of a free oscillation that are run if no duration is given.
PERIODS = 10

#: Uncertainty of the reference that is aimed at, as a part of the smallest error asked for, and the most that is taken.
AIMED, ACCEPTED = 1 / 100, 1 / 10

#: Least part of the duration that a reference must hold.
SHORTEST = 0.05

#: Timed runs of a recommended step.
REPEATS = 5

#: Steps of a run that is timed to measure a step, and the longest time that they may take.
TIMED_STEPS, TIMED_SECONDS = 2_000, 0.2


class _Reference(NamedTuple):
    """The solution, what it says, how far it is to be trusted, and until when."""

    solution: Solution
    targets: dict[str, Target]
    uncertainty: dict[str, float]
    route: Route
    witness: Route
    rtol: float
    horizon: float


def processor() -> str:
    """Name of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def _chosen_schemes(given: str | Scheme | Mapping[str, Scheme] | Iterable[str | Scheme] | None) -> dict[str, Scheme]:
    """Schemes by the name under which the dataset has them."""
    if given is None:
        return {name: schemes_by_name[name] for name in USUAL}
    if isinstance(given, Mapping):
        return {name: resolve(one, schemes_by_name, Scheme) for name, one in given.items()}  # type: ignore[type-abstract]
    chosen: dict[str, Scheme] = {}
    for one in [given] if isinstance(given, str | Scheme) else given:
        scheme = resolve(one, schemes_by_name, Scheme)  # type: ignore[type-abstract]
        name = schemes_by_name.resolve(one) if isinstance(one, str) else scheme.title
        if name in chosen:
            raise ValueError(f"two schemes have the name '{name}'; give a mapping from names to schemes.")
        chosen[name] = scheme
    if not chosen:
        raise ValueError("schemes is empty; name at least one, or leave it out for the usual ones.")
    return chosen


def _checked_errors(allowed: Sequence[float]) -> list[float]:
    """Allowed errors, the largest first."""
    values = np.atleast_1d(np.asarray(allowed, float))
    if not values.size or not np.all((values > 0) & (values < 1)):
        raise ValueError(f"errors must be fractions between zero and one, such as 0.01 for one percent, not {allowed}.")
    return sorted(set(values.tolist()), reverse=True)


def _periods(problem: Problem) -> tuple[float, float] | None:
    """Periods of the slowest and the fastest small motion about the start, or about u = 0 where the start has none."""
    for at in (None, np.zeros(np.shape(problem.u0))):
        found = frequencies(problem, at)
        oscillating = [] if found is None else found[(found > 0) & np.isfinite(found)]
        if len(oscillating):
            return float(2 * np.pi / oscillating[0]), float(2 * np.pi / oscillating[-1])
    return None


def _duration(problem: Problem, duration: float | None) -> float:
    """Length of the runs: as given, or ten periods of a free oscillator."""
    if duration is not None:
        if isinstance(duration, bool) or not isinstance(duration, int | float | np.number) or not 0 < duration < np.inf:
            raise ValueError(f"duration must be a time in seconds greater than zero, not {duration!r}.")
        return float(duration)
    free = np.ndim(problem.u0) == 0 and problem.damping is None and problem.load is None
    periods = _periods(problem)
    if not free or periods is None:
        raise ValueError(f"'{problem.title}' has no period to count in: give duration=, the time to be run.")
    return PERIODS * periods[0]


def _holds(one: Solution, other: Solution, quantities: dict[str, Quantity], problem: Problem, most: float) -> float:
    """Time up to which two solutions agree in every quantity."""
    ends = [one.t[-1]]
    for quantity in quantities.values():
        _, along = errors.difference(quantity, problem, one, other)
        apart = np.flatnonzero(~(along <= most))
        ends.append(one.t[apart[0]] if apart.size else one.t[-1])
    return float(min(ends))


def _reference(
    problem: Problem, duration: float, quantities: dict[str, Quantity], tightest: float, coarsest: float
) -> _Reference:
    """The reference, from two routes whose tolerance is tightened until they agree.

    Raises
    ------
    NoReference
        If the routes fail, or agree over a small part of the duration only.
    ValueError
        If the problem has no motion.
    """
    route, witness = certified.routes_of(problem, duration)
    grid = certified.grid_of(problem, duration, coarsest)
    reached: tuple | None = None
    for rtol in certified.TOLERANCES:
        try:
            one, other = (certified.solution_by(r, problem, grid, rtol) for r in (route, witness))
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
    return _Reference(one, targets, apart, route, witness, rtol, horizon)


def _until(solution: Solution, end: float) -> Solution:
    """The solution up to a time of its grid."""
    count = int(np.searchsorted(solution.t, end, side="right"))
    return Solution(*(part[:count] for part in solution))


def _cases(problem: Problem, reference: _Reference, quantities: dict[str, Quantity]) -> dict[float, Case]:
    """The problem and its neighbours, each with its own reference."""
    cases = {1.0: Case(problem, reference.solution, reference.targets)}
    for factor in ladder.STARTS:
        neighbour = excited(problem, factor, displaced=True)
        solution = certified.solution_by(reference.route, neighbour, reference.solution.t, reference.rtol)
        targets = {name: errors.target(quantity, neighbour, solution) for name, quantity in quantities.items()}
        cases[factor] = Case(neighbour, solution, targets)
    return cases


class _Assessed(NamedTuple):
    """What was found out about one scheme."""

    rungs: Ladder
    verdicts: dict[tuple[str, float], Verdict]
    map: xr.Dataset | None


def assess(
    problem: str | Problem,
    schemes: str | Scheme | Mapping[str, Scheme] | Iterable[str | Scheme] | None = None,
    *,
    duration: float | None = None,
    quantities: Mapping[str, Quantity] | None = None,
    errors: Sequence[float] = (0.1, 0.01, 0.001),
    maps: bool = True,
) -> xr.Dataset:
    """Find out which scheme and which step a problem needs for an error, by runs against a certified reference.

    Two independent solvers give the reference and its uncertainty. Every scheme runs at ever finer steps, each half of
    the one before, until it keeps the smallest error. Runs between them find the largest step that keeps each error and
    from which on every finer step keeps it. Three finer steps and two starts, one percent apart from the given one,
    must keep it too; otherwise the step kept the error by accident, and the search goes on. No number is interpolated.

    Parameters
    ----------
    problem
        Name in ``study.problems``, or your own :class:`study.Problem`.
    schemes
        Names in ``study.schemes``, your own :class:`study.Scheme`, or a mapping from names to schemes; ten usual ones
        by default.
    duration
        Time of the runs in seconds. A free oscillator of one unknown runs ten of its periods by default.
    quantities
        What must be right: a mapping from names to :class:`study.Quantity`. By default the displacement and velocity
        along time, and the balance of energies if the problem has a potential.
    errors
        Errors that may be allowed, as fractions of the largest value of each quantity.
    maps
        Whether to map over step size and excitation how each scheme fails.

    Returns
    -------
    xarray.Dataset
        Over ``scheme``, ``dt`` and ``quantity``: ``error``, ``status``, ``energy_imbalance``, ``newton_iterations``,
        NaN where a step was not tried. Over ``scheme``, ``quantity`` and ``allowed_error``: ``recommended_dt``,
        ``verdict``, ``time`` with its spread, ``force_evaluations``. Over ``quantity``: ``reference_uncertainty``.
        Attributes name the routes of the reference, the time up to which it holds, versions and processor.
        :func:`study.recommend` and :func:`study.report` take it.

    Raises
    ------
    KeyError
        If there is no such problem or scheme.
    TypeError, ValueError
        If an argument is unfit, the problem does not move, or no reference is accurate enough; in one sentence.

    Examples
    --------
    >>> pendulum = study.Problem(jnp.sin, potential=lambda u: 1 - jnp.cos(u), u0=1.0, title="pendulum")
    >>> ds = study.assess(pendulum, ["average_acceleration", "rk4"])  # doctest: +SKIP
    >>> study.recommend(ds, error=0.01, quantity="displacement")  # doctest: +SKIP
    """
    # as a multiple of itself it shares what is compiled with its neighbours
    equation = excited(resolve(problem, problems, Problem), 1.0, displaced=True)
    chosen, allowed = _chosen_schemes(schemes), _checked_errors(errors)
    asked = _errors_of(quantities)
    of_energy = quantities is None and equation.potential is not None
    length = _duration(equation, duration)
    for quantity in asked.values():
        if reason := quantity.refusal(equation):
            raise ValueError(reason)
    fit = {name: one for name, one in chosen.items() if not one.refusal(equation)}
    if not fit:
        raise ValueError(next(iter(chosen.values())).refusal(equation))
    slowest, fastest = _periods(equation) or (length / ladder.COARSEST,) * 2
    coarsest = slowest / ladder.COARSEST
    reference = _reference(equation, length, asked, allowed[-1], coarsest)
    length = reference.horizon
    cases = _cases(equation, reference, asked)
    uncertainty = reference.uncertainty | ({ENERGY: 0.0} if of_energy else {})
    names = [*asked, *([ENERGY] if of_energy else [])]
    first = max(ladder.COARSEST, int(np.ceil(length / coarsest)))
    finest = min(ladder.MOST_STEPS, int(length / min(slowest / ladder.FINEST, fastest / ladder.FINEST_OF_FASTEST)))

    def of(scheme: Scheme) -> _Assessed:
        rungs = Ladder(scheme, cases, length, of_energy)
        rungs.climb(rungs.rounded(first), finest, allowed[-1])
        verdicts = {(name, error): rungs.verdict(name, error, uncertainty[name]) for name in names for error in allowed}
        return _Assessed(rungs, verdicts, failures.map_of(equation, scheme, length, coarsest) if maps else None)

    found = _each(fit, of)
    ds = _dataset(equation, found, {name: chosen[name] for name in found}, names, allowed, length)
    ds["reference_uncertainty"] = (
        "quantity",
        [uncertainty[name] for name in names],
        {"long_name": "difference of the reference from its witness, relative", "units": "1"},
    )
    ds.attrs |= {
        "reference": reference.route.name,
        "witness": reference.witness.name,
        "reference_tolerance": reference.rtol,
        "duration": length,
        "duration_asked_for": _duration(equation, duration),
        "problem": equation.title,
        "processor": processor(),
        "not_fit": "; ".join(str(chosen[name].refusal(equation)) for name in chosen if name not in fit),
    }
    return ds


def _errors_of(quantities: Mapping[str, Quantity] | None) -> dict[str, Quantity]:
    asked = errors.named(quantities)
    if ENERGY in asked:
        raise ValueError(f"the name '{ENERGY}' is that of the balance of energies; give the quantity another.")
    return asked


def _each(schemes: dict[str, Scheme], of: Callable[[Scheme], _Assessed]) -> dict[str, _Assessed]:
    """What was found out about each scheme; after Ctrl-C, about those that are done."""
    found: dict[str, _Assessed] = {}
    with ThreadPoolExecutor(min(cores(), len(schemes))) as pool:
        waiting = {name: pool.submit(of, scheme) for name, scheme in schemes.items()}
        try:
            for name in tqdm(waiting, disable=None, leave=False, unit="scheme"):
                found[name] = waiting[name].result()
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            found = {name: one.result() for name, one in waiting.items() if one.done() and not one.cancelled()}
            if not found:
                raise
            left = [name for name in schemes if name not in found]
            warnings.warn(f"interrupted: {', '.join(left)} were not assessed.", RuntimeWarning, stacklevel=3)
    return found


def _timed(problem: Problem, scheme: Scheme, duration: float, wanted: set[int]) -> dict[int, tuple[float, float]]:
    """Median time of a run and its interquartile range, by number of steps."""
    timed = Timed(problem, scheme, ())
    times = {}
    for steps in sorted(wanted):
        taken = [timed.run(duration / steps, steps)[0] for _ in range(REPEATS)]
        low, median, high = np.quantile(taken, [0.25, 0.5, 0.75])
        times[steps] = float(median), float(high - low)
    return times


def _dataset(
    problem: Problem,
    found: dict[str, _Assessed],
    schemes: dict[str, Scheme],
    names: list[str],
    allowed: list[float],
    duration: float,
) -> xr.Dataset:
    """Everything that was found out, with times, which are taken one scheme after the other."""
    steps = sorted({n for one in found.values() for n in one.rungs.steps_of()}, reverse=True)[::-1]
    place = {n: i for i, n in enumerate(steps)}
    shape = (len(found), len(steps))
    error = np.full((*shape, len(names)), np.nan)
    status = np.full(shape, NOT_TRIED, np.int8)
    imbalance, iterations = np.full(shape, np.nan), np.full(shape, np.nan)
    on_ladder = np.zeros(shape, np.int8)
    best = (len(found), len(names), len(allowed))
    dt, time, spread, forces, reached = (np.full(best, np.nan) for _ in range(5))
    how, accidents = np.zeros(best, np.int8), np.zeros(best, np.int32)
    time_per_step = np.full(len(found), np.nan)
    for s, (name, one) in enumerate(found.items()):
        scheme = schemes[name]
        for n in one.rungs.steps_of():
            run = one.rungs.run(n)
            i = place[n]
            error[s, i] = [run.errors[q] for q in names]
            status[s, i], imbalance[s, i], iterations[s, i] = run.status, run.imbalance, run.iterations
        on_ladder[s, [place[n] for n in one.rungs.rungs]] = 1
        wanted = {v.steps for v in one.verdicts.values() if v.steps > 0}
        times = _timed(problem, scheme, duration, wanted) if wanted else {}
        if times:
            longest = max(times)
            time_per_step[s] = times[longest][0] / longest
        for (quantity, limit), verdict in one.verdicts.items():
            at = s, names.index(quantity), allowed.index(limit)
            how[at], accidents[at] = verdict.how, verdict.accidents
            if verdict.steps > 0:
                run = one.rungs.run(verdict.steps)
                per_step = scheme.evaluations + scheme.evaluations_per_iteration * run.iterations
                dt[at], (time[at], spread[at]) = duration / verdict.steps, times[verdict.steps]
                forces[at], reached[at] = verdict.steps * per_step, run.errors[quantity]
    runs, verdicts = ("scheme", "dt"), ("scheme", "quantity", "allowed_error")
    ds = xr.Dataset(
        {
            "error": ((*runs, "quantity"), error, {"long_name": "error relative to the largest value", "units": "1"}),
            "status": (runs, status, flags("how the run ended", STATUSES, np.int8)),
            "on_ladder": (
                runs,
                on_ladder,
                flags("which run this is", ("between_rungs", "rung_of_the_ladder"), np.int8),
            ),
            "energy_imbalance": (runs, imbalance, {"long_name": "error of the balance of energies", "units": "1"}),
            "newton_iterations": (runs, iterations, {"long_name": "Newton iterations a step", "units": "1"}),
            "recommended_dt": (verdicts, dt, {"long_name": "largest step that keeps the error", "units": "s"}),
            "recommended_error": (verdicts, reached, {"long_name": "error at that step", "units": "1"}),
            "verdict": (verdicts, how, flags("how the search for the step ended", ladder.VERDICTS, np.int8)),
            "accidents": (verdicts, accidents, {"long_name": "steps that kept the error by accident", "units": "1"}),
            "time": (verdicts, time, {"long_name": "time of a run with that step, median", "units": "s"}),
            "time_spread": (verdicts, spread, {"long_name": "its interquartile range", "units": "s"}),
            "force_evaluations": (verdicts, forces, {"long_name": "forces evaluated in that run", "units": "1"}),
            "time_per_step": ("scheme", time_per_step, {"long_name": "time of a step", "units": "s"}),
        },
        {
            "scheme": ("scheme", list(found), {"long_name": "time integration scheme"}),
            "scheme_title": ("scheme", [schemes[name].title for name in found], {"long_name": "name of the scheme"}),
            "dt": ("dt", duration / np.array(steps), {"long_name": "step size", "units": "s"}),
            "steps": ("dt", steps, {"long_name": "number of steps", "units": "1"}),
            "quantity": ("quantity", names, {"long_name": "what must be right"}),
            "allowed_error": ("allowed_error", allowed, {"long_name": "largest error allowed", "units": "1"}),
        },
        datasets.provenance(f"Which scheme and which step for the {problem.title}", "study.assess"),
    )
    parts = {name: one.map for name, one in found.items() if one.map is not None}
    if parts:
        ds = ds.merge(xr.concat(list(parts.values()), "scheme").assign_coords(scheme=list(parts)))
    return ds


#: How a run of a ladder can end; most steps of a scheme are not tried.
STATUSES = ("completed", "newton_not_converged", "not_finite", "not_tried")
NOT_TRIED = STATUSES.index("not_tried")
