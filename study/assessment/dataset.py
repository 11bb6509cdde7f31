"""The results of an assessment as a dataset, with the times of the recommended steps."""

import itertools
import math
import time
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from study import io
from study.assessment.search import UNCERTAIN, VERDICTS, Verdict
from study.io import flags
from study.marching.result import STATUSES
from study.marching.timing import Timed
from study.mechanics.definition import Problem
from study.scheme.base import Scheme
from study.sizes import Limit
from study.warn import warn

#: Timing of a recommended step: number of turns in which all schemes are timed, least number of timed runs in a turn,
#: time in s that a timed run should take, and largest number of steps of a timed run.
TURNS, REPEATS, ENOUGH, MOST_TIMED = 2, 3, 0.003, 20_000
#: Ratio of two times that nearly agree, number of runs that must nearly agree with the shortest one, and time in s from
#: which on no run is added for this.
NEARLY, AGREEING, PATIENCE = 1.1, 3, 1.0

#: Outcomes of a run; the last one marks steps that were not tried.
ENDS = (*STATUSES, "not_tried")
NOT_TRIED = ENDS.index("not_tried")


#: Attributes of the coordinates that only schemes of the package have, not those of a program.
SCHEME_ATTRIBUTES = {
    "order": {"long_name": "order of accuracy", "units": "1"},
    "order_of_loss": {
        "long_name": "order of the loss of energy in free vibration, infinite if there is none",
        "units": "1",
    },
}
#: Attributes of the other variables.
ATTRIBUTES = {
    "error": {"long_name": "error, relative to the value that relative_to states", "units": "1"},
    "status": flags("how the run ended", ENDS, np.int8),
    "energy_imbalance": {"long_name": "error of the balance of energies", "units": "1"},
    "newton_iterations_per_step": {"long_name": "Newton iterations per step", "units": "1"},
    "recommended_step_size": {
        "long_name": "recommended step: the largest round step that keeps the error, as all finer ones do",
        "units": "s",
    },
    "largest_step_size": {"long_name": "largest step tried that keeps the error, as all finer ones do", "units": "s"},
    "recommended_error": {"long_name": "error at the recommended step", "units": "1"},
    "steps_tried": {"long_name": "steps tried from a twentieth of the recommended one up to it", "units": "1"},
    "largest_error": {"long_name": "largest error of the steps tried", "units": "1"},
    "verdict": flags("how the search for the step ended", VERDICTS, np.int8),
    "seconds": {"long_name": "shortest time of all steps of the recommended run in repeated runs", "units": "s"},
    "seconds_spread": {"long_name": "interquartile range of the times of these runs", "units": "s"},
    "force_evaluations": {"long_name": "internal forces evaluated in the recommended run", "units": "1"},
    "seconds_per_step": {"long_name": "time of a step", "units": "s"},
    "scheme": {"long_name": "time integration scheme"},
    "scheme_title": {"long_name": "name of the scheme"},
    "kind": {"long_name": "explicit or implicit"},
    "step_size": {"long_name": "step size", "units": "s"},
    "steps": {"long_name": "number of steps", "units": "1"},
    "quantity": {"long_name": "quantity whose error is measured"},
    "allowed_error": {"long_name": "largest allowed error", "units": "1"},
}


class Assessed(NamedTuple):
    """Results of one scheme."""

    runs: pd.DataFrame
    verdicts: dict[Limit, Verdict]
    map_or_limit: xr.Dataset
    tolerances: dict[Limit, Verdict] | None = None


def times_of_steps(timed: Timed, steps_by_dt: dict[float, int]) -> dict[float, tuple[float, float]]:
    """Shortest time in s of all steps of a run, and the interquartile range of the repeated runs, by step size.

    Other work on the machine only lengthens a run, so that the shortest one is nearest to the time of the scheme. Runs
    are repeated until ``AGREEING`` of them nearly take the shortest time, as long as they take less than ``PATIENCE``
    seconds together.

    ``steps_by_dt`` maps each step size to the number of steps of its run. A timed run has this number, but at most
    ``MOST_TIMED``. If they take less than ``ENOUGH`` seconds, it has more steps, unless one of these fails. Its time is
    scaled to the number of steps wanted. The overhead of a call is the time of a run of one step. It is subtracted from
    that time if it exceeds twice the overhead.
    """

    def repeated(dt: float, steps: int) -> list[tuple[float, bool]]:
        runs = list[tuple[float, bool]]()
        while len(runs) < REPEATS or (
            sum(seconds <= NEARLY * min(runs)[0] for seconds, _ in runs) < AGREEING
            and sum(seconds for seconds, _ in runs) < PATIENCE
        ):
            runs.append(timed.run(dt, steps))
        return runs

    call, _ = min(repeated(max(steps_by_dt), 1))
    times = {}
    for dt, steps in sorted(steps_by_dt.items(), reverse=True):
        timed_steps = min(steps, MOST_TIMED)
        runs = repeated(dt, timed_steps)
        once = max(min(runs)[0] - call, ENOUGH * timed_steps / MOST_TIMED)
        if once < ENOUGH:
            more = int(timed_steps * ENOUGH / once)
            longer = repeated(dt, more)
            # steps beyond the wanted number may fail; the run is then timed without them
            if all(completed for _, completed in longer):
                timed_steps, runs = more, longer
        shortest, low, high = np.quantile([seconds for seconds, _ in runs], [0.0, 0.25, 0.75])
        less = call if shortest > 2 * call else 0.0
        times[dt] = float((shortest - less) * steps / timed_steps), float((high - low) * steps / timed_steps)
    return times


def _times(
    problem: Problem, schemes: dict[str, Scheme], results: dict[str, Assessed], end: float = math.inf
) -> dict[str, dict]:
    """Times of recommended steps by scheme: the shorter ones of several turns, each through all schemes.

    A slow second of the machine thus lengthens the times of no scheme alone. After Ctrl-C, or after ``end`` of the
    monotonic clock, only the finished schemes have times.
    """
    times, timed, longest = dict[str, dict](), dict[str, Timed](), 0.0
    for _, (name, result) in itertools.product(range(TURNS), results.items()):
        if (begin := time.monotonic()) + longest > end:
            break
        steps_by_dt = {v.recommended: int(v.steps) for v in result.verdicts.values() if v.recommended > 0}
        try:
            if steps_by_dt and name not in timed:
                timed[name] = Timed(problem, schemes[name], ())
            turn = times_of_steps(timed[name], steps_by_dt) if steps_by_dt else {}
        except KeyboardInterrupt:
            if untimed := [other for other in results if other not in times]:
                warn(f"interrupted: {', '.join(untimed)} have no times.")
            break
        times[name] = {dt: min(turn[dt], times.get(name, turn)[dt]) for dt in turn}
        longest = max(longest, time.monotonic() - begin)
    return times


def dataset_of(
    problem: Problem,
    results: dict[str, Assessed],
    schemes: dict[str, Scheme],
    names: list[str],
    allowed: list[float],
    end: float = math.inf,
) -> xr.Dataset:
    """Results of all schemes, with the times of the recommended steps, as a dataset."""
    times_by_scheme = _times(problem, schemes, results, end)
    runs = {
        name: result.runs[result.runs.start == 1.0].set_index("dt").rename_axis("step_size")
        for name, result in results.items()
    }
    tried = pd.concat(runs, names=["scheme"]).to_xarray().sel(scheme=list(results)).sortby("step_size", ascending=False)
    rows = []
    for name, result in results.items():
        times = times_by_scheme.get(name, {})
        for limit in ((quantity, error) for quantity in names for error in allowed):
            verdict = result.verdicts.get(limit, Verdict(UNCERTAIN))
            rows.append((name, *limit, *verdict, *times.get(verdict.recommended, (np.nan,) * 2)))
    index = ["scheme", "quantity", "allowed_error"]
    variables = [
        "verdict",
        "largest_step_size",
        "recommended_step_size",
        "steps_tried",
        "largest_error",
        "recommended_error",
        "recommended_steps",
        "force_evaluations",
        "seconds",
        "seconds_spread",
    ]
    verdicts = pd.DataFrame(rows, columns=[*index, *variables]).drop(columns="recommended_steps")
    ds = verdicts.set_index(index).to_xarray().sel(scheme=list(results), quantity=names, allowed_error=allowed)
    ds = ds.assign(verdict=ds.verdict.astype(np.int8), steps_tried=ds.steps_tried.astype(np.int32))
    ds["error"] = tried[names].to_dataarray("quantity").transpose("scheme", "step_size", "quantity")
    ds["status"] = tried.status.fillna(NOT_TRIED).astype(np.int8)
    ds["energy_imbalance"], ds["newton_iterations_per_step"] = tried.imbalance, tried.iterations
    finest = {name: min(times_by_scheme.get(name, {}), default=np.nan) for name in results}
    ds["seconds_per_step"] = (
        "scheme",
        [times_by_scheme[n][dt][0] / runs[n].steps[dt] if dt > 0 else np.nan for n, dt in finest.items()],
    )
    ds = ds.assign_coords(
        scheme_title=("scheme", [schemes[name].title for name in results]),
        kind=("scheme", ["explicit" if schemes[name].explicit else "implicit" for name in results]),
        order=("scheme", [schemes[name].order for name in results]),
        order_of_loss=("scheme", [schemes[name].order_of_loss for name in results]),
        steps=tried.steps.max("scheme").astype(int),
    )
    for name, attributes in (ATTRIBUTES | SCHEME_ATTRIBUTES).items():
        ds[name].attrs |= attributes
    ds.attrs = io.provenance(f"Which scheme and which step: {problem.title}", "study.assess", io.now())
    parts = [result.map_or_limit for result in results.values()]
    if not all("outcome" in part for part in parts):  # without time for all maps
        parts = [part[["stable_step_size"]].sel(excitation=[1.0]) for part in parts]
    return ds.merge(xr.concat(parts, "scheme").assign_coords(scheme=list(results)))
