"""Work and precision of the schemes: time, force evaluations and Newton iterations, and the errors."""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import xarray as xr

from study import io
from study.declaration.checks import unlisted
from study.declaration.experiment import Options, experiment, merged, progress
from study.declaration.options import Repeats, RisingCounts, Schemes, Springs
from study.experiments import coordinates
from study.marching.timing import Timed
from study.observer.energy import EnergyDrift
from study.problem.named import problems as problems_by_name
from study.scheme.named import schemes as schemes_by_name

#: Smallest duration of a timed run in seconds, approximately. The overhead of a call is only a tenth of a millisecond.
LONG_ENOUGH = 0.004
#: Number of steps of a first run, whose duration gives the number of steps of the timed runs.
FIRST_STEPS = 10_000


def _check(options: Options, configuration: Mapping) -> str | None:
    """Refuse problems, schemes and step sizes whose errors ``accuracy`` does not measure.

    An ``accuracy`` without runs of 100 periods is refused too.
    """
    for key in ("problems", "schemes", "steps_per_period"):
        refused = unlisted(key, options[key], f"accuracy.{key}", configuration["accuracy"][key])
        if refused is not None:
            return refused
    if 100 not in configuration["accuracy"]["periods"]:
        return "schemes: accuracy.periods must contain 100, from which Newton's iterations are taken."
    return None


merged("work_precision", of=("work_precision/schemes", "work_precision/solvers"))


@experiment(
    "work_precision/schemes",
    reads=lambda options: ["accuracy", *(f"reference/{problem}" for problem in options["problems"])],
    check=_check,
    timed=True,
    temporary=True,
)
def work_precision(problems: Springs, schemes: Schemes, steps_per_period: RisingCounts, repeats: Repeats) -> xr.Dataset:
    """Measure time, force evaluations and Newton iterations of a step of every scheme, and its errors.

    The result is the dataset ``accuracy``, which holds the errors, with the costs added. The schemes are timed in
    turns, so that a slow moment of the machine affects all of them. Times of a step have the shape (problem, scheme,
    steps_per_period, repeat), in s; they are NaN for a run that failed.

    Raises
    ------
    FileNotFoundError
        If ``accuracy`` or the reference of a problem has not been made.
    """
    accuracy = io.open_dataset("accuracy")
    accuracy = accuracy.sel(problem=problems, scheme=schemes, steps_per_period=steps_per_period)
    shape = (len(problems), len(schemes), len(steps_per_period))
    per_step = np.full((*shape, repeats), np.nan)
    chosen = [schemes_by_name[scheme] for scheme in schemes]
    for p, problem in enumerate(problems):
        progress(f"timing on {problem}")
        period = io.open_dataset(f"reference/{problem}").period.item()
        # the programs are compiled concurrently, because nothing is timed yet; the runs are timed one after the other
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            timed = list(pool.map(partial(Timed, problems_by_name[problem], reductions=(EnergyDrift(),)), chosen))
        for k, parts in enumerate(steps_per_period):
            dt = period / parts
            steps = [int(FIRST_STEPS * max(1, LONG_ENOUGH / timer.run(dt, FIRST_STEPS)[0])) for timer in timed]
            for repeat in range(repeats):
                for s, timer in enumerate(timed):
                    seconds, completed = timer.run(dt, steps[s])
                    per_step[p, s, k, repeat] = seconds / steps[s] if completed else np.nan
    dims = ("problem", "scheme", "steps_per_period")
    steps_of_run = accuracy.steps_per_period * accuracy.periods
    iterations = (accuracy.newton_iterations / steps_of_run).sel(periods=100).transpose(*dims).values
    evaluations = (accuracy.force_evaluations / steps_of_run).sel(periods=100).transpose(*dims).values
    median, quartiles = np.median(per_step, axis=-1), np.quantile(per_step, [0.25, 0.75], axis=-1)
    ds = accuracy.assign(
        seconds_per_step=((*dims, "repeat"), per_step, {"long_name": "time of one step, by repeat", "units": "s"}),
        median_seconds_per_step=(dims, median, {"long_name": "median time of one step", "units": "s"}),
        spread_of_seconds_per_step=(
            dims,
            quartiles[1] - quartiles[0],
            {"long_name": "interquartile range of the time of one step", "units": "s"},
        ),
        newton_iterations_per_step=(
            dims,
            iterations,
            {"long_name": "Newton iterations per step, each with one tangent and one solve", "units": "1"},
        ),
        force_evaluations_per_step=(dims, evaluations, {"long_name": "forces evaluated per step", "units": "1"}),
    )
    ds = ds.assign(
        median_seconds=(ds.median_seconds_per_step * steps_of_run).assign_attrs(
            long_name="median time of a step times the number of steps", units="s"
        ),
    )
    numbered = ("repeat", np.arange(repeats), {"long_name": "repeat", "units": "1"})
    return ds.assign_coords(repeat=numbered, **coordinates.scheme_coordinates(schemes)).assign_attrs(
        title="Work and precision of schemes and solvers"
    )
