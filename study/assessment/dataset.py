"""What an assessment found out, as a dataset, with the times of the recommended steps."""

import warnings
from typing import NamedTuple

import numpy as np
import xarray as xr

from study import io
from study.assessment import ladder
from study.assessment.ladder import Ladder, Recommendation
from study.io import flags
from study.marching.result import STATUSES
from study.marching.timing import Timed
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.scheme.wrapper.with_history import WithHistory

#: Timed runs of a recommended step, the seconds that suffice for each, and the most steps that short runs are given.
REPEATS, ENOUGH, MOST_TIMED = 5, 0.02, 20_000

#: How a run of a ladder can end; most steps of a scheme are not tried.
ENDS = (*STATUSES, "not_tried")
NOT_TRIED = ENDS.index("not_tried")


class Assessed(NamedTuple):
    """What was found out about one scheme."""

    rungs: Ladder
    verdicts: dict[tuple[str, float], Recommendation]
    map: xr.Dataset | None


def _timed(problem: Problem, scheme: Scheme, duration: float, wanted: set[int]) -> dict[int, tuple[float, float]]:
    """Median time of the steps of a run and its interquartile range, by number of steps.

    Short runs are timed over more steps of the same size, as many as a clock needs, and the time of a run of one step
    is subtracted: it is that of the call. Where a run cannot be told from the call, its time has the call in it.
    """
    timed = Timed(problem, scheme, ())
    call = np.median([timed.run(duration / min(wanted), 1)[0] for _ in range(REPEATS)])
    times = {}
    for steps in sorted(wanted):
        once = max(timed.run(duration / steps, steps)[0] - call, ENOUGH * steps / MOST_TIMED)
        most = max(steps, int(steps * ENOUGH / once))
        runs = [timed.run(duration / steps, most) for _ in range(REPEATS)]
        if not all(completed for _, completed in runs):  # it fails beyond the time that is asked for
            most, runs = steps, [timed.run(duration / steps, steps) for _ in range(REPEATS)]
        low, median, high = np.quantile([taken for taken, _ in runs], [0.25, 0.5, 0.75])
        less = call if median > 2 * call else 0.0
        times[steps] = float((median - less) * steps / most), float((high - low) * steps / most)
    return times


def _times(
    problem: Problem, schemes: dict[str, Scheme], found: dict[str, Assessed], duration: float
) -> dict[str, dict]:
    """Times by scheme, taken one after the other; after Ctrl-C, of those that are done."""
    times = {}
    for name, one in found.items():
        wanted = {v.steps for v in one.verdicts.values() if v.steps > 0}
        try:
            times[name] = _timed(problem, schemes[name], duration, wanted) if wanted else {}
        except KeyboardInterrupt:
            left = [other for other in found if other not in times]
            warnings.warn(f"interrupted: {', '.join(left)} have no times.", RuntimeWarning, stacklevel=4)
            break
    return times


def dataset_of(
    problem: Problem,
    found: dict[str, Assessed],
    schemes: dict[str, Scheme],
    names: list[str],
    allowed: list[float],
    duration: float,
) -> xr.Dataset:
    """Everything that was found out, with times."""
    of_scheme = _times(problem, schemes, found, duration)
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
        times = of_scheme.get(name, {})
        if times:
            longest = max(times)
            time_per_step[s] = times[longest][0] / longest
        for (quantity, limit), verdict in one.verdicts.items():
            at = s, names.index(quantity), allowed.index(limit)
            how[at], accidents[at] = verdict.how, verdict.accidents
            if verdict.steps > 0:
                run = one.rungs.run(verdict.steps)
                marched = scheme if problem.history is None else WithHistory(scheme)
                per_step = marched.forces_per_step + marched.forces_per_iteration * run.iterations
                dt[at], (time[at], spread[at]) = duration / verdict.steps, times.get(verdict.steps, (np.nan,) * 2)
                forces[at], reached[at] = verdict.steps * per_step, run.errors[quantity]
    runs, verdicts = ("scheme", "dt"), ("scheme", "quantity", "allowed_error")
    ds = xr.Dataset(
        {
            "error": ((*runs, "quantity"), error, {"long_name": "error relative to the largest value", "units": "1"}),
            "status": (runs, status, flags("how the run ended", ENDS, np.int8)),
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
            "accidents": (
                verdicts,
                accidents,
                {"long_name": "steps that kept the error, unlike a finer one or another start", "units": "1"},
            ),
            "time": (verdicts, time, {"long_name": "time of the steps of a run, median", "units": "s"}),
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
        io.provenance(f"Which scheme and which step for the {problem.title}", "study.assess"),
    )
    parts = {name: one.map for name, one in found.items() if one.map is not None}
    if parts:
        ds = ds.merge(xr.concat(list(parts.values()), "scheme").assign_coords(scheme=list(parts)))
    return ds
