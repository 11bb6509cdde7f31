"""What accuracy costs: the time, the forces and the Newton iterations of every scheme beside its errors."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.command import main, progress
from study.experiments import labels
from study.observers import EnergyDrift, NewtonIterations
from study.problems import problems as problems_by_name
from study.runs import run
from study.schemes import schemes as schemes_by_name
from study.timing import Timed

#: Steps of a run that is timed, at least: a call takes a tenth of a millisecond, which they make small.
LEAST_STEPS = 200_000


def _newton_iterations(problem: str, scheme: str, dt: float, steps: int) -> float:
    """Newton iterations of a step, on average over the run; NaN where it failed."""
    ds = run(problem, scheme, dt=dt, steps=steps, observe=[NewtonIterations()])
    return 0.0 if schemes_by_name[scheme].explicit else ds.newton_iterations.item() / steps


def work_precision(
    problems: Sequence[str], schemes: Sequence[str], steps_per_period: Sequence[int], repeats: int
) -> xr.Dataset:
    """Cost of a step in three currencies, by steps per exact period, beside the errors of ``accuracy``.

    The schemes take turns, so that a slow moment of the machine meets all of them. A run that failed has no cost.
    """
    accuracy = datasets.open("accuracy").sel(problem=problems, scheme=schemes, steps_per_period=steps_per_period)
    shape = tuple(map(len, (problems, schemes, steps_per_period)))
    per_step, iterations = np.full((*shape, repeats), np.nan), np.empty(shape)
    compile_time = np.empty(shape[:2])
    for p, problem in enumerate(problems):
        progress(f"timing on {problem}")
        period = datasets.open(f"reference/{problem}").period.item()
        timed = [Timed(problems_by_name[problem], schemes_by_name[scheme], (EnergyDrift(),)) for scheme in schemes]
        compile_time[p] = [one.compile_time for one in timed]
        for k, parts in enumerate(steps_per_period):
            dt, steps = period / parts, max(LEAST_STEPS, 100 * parts)
            iterations[p, :, k] = [_newton_iterations(problem, scheme, dt, 100 * parts) for scheme in schemes]
            for repeat in range(repeats):
                for s, one in enumerate(timed):
                    seconds, completed = one.run(dt, steps)
                    per_step[p, s, k, repeat] = 1e9 * seconds / steps if completed else np.nan
    evaluations = iterations + np.array([[schemes_by_name[scheme].evaluations] for scheme in schemes])
    median, quartiles = np.median(per_step, axis=-1), np.quantile(per_step, [0.25, 0.75], axis=-1)
    dims = ("problem", "scheme", "steps_per_period")
    steps_of_run = accuracy.steps_per_period * accuracy.periods
    ds = accuracy.assign(
        time_per_step=((*dims, "repeat"), per_step, {"long_name": "time of one step, by repeat", "units": "ns"}),
        median_time_per_step=(dims, median, {"long_name": "median time of one step", "units": "ns"}),
        spread_of_time_per_step=(
            dims,
            quartiles[1] - quartiles[0],
            {"long_name": "interquartile range of the time of one step", "units": "ns"},
        ),
        compile_time=(dims[:2], compile_time, {"long_name": "time to trace and compile", "units": "s"}),
        newton_iterations_per_step=(
            dims,
            iterations,
            {"long_name": "Newton iterations a step: each one force, one tangent, one solve", "units": "1"},
        ),
        force_evaluations_per_step=(dims, evaluations, {"long_name": "forces evaluated a step", "units": "1"}),
    )
    ds = ds.assign(
        time_per_run=(1e-9 * ds.median_time_per_step * steps_of_run).assign_attrs(
            long_name="median time of a run: of a step times the number of steps", units="s"
        ),
        force_evaluations=(ds.force_evaluations_per_step * steps_of_run).assign_attrs(
            long_name="forces evaluated in a run", units="1"
        ),
        newton_iterations=(ds.newton_iterations_per_step * steps_of_run).assign_attrs(
            long_name="Newton iterations, and tangents solved, in a run", units="1"
        ),
    )
    numbered = ("repeat", np.arange(repeats), {"long_name": "repeat", "units": "1"})
    return ds.assign_coords(repeat=numbered, **labels.scheme_coordinates(schemes)).assign_attrs(
        title="Work and precision of schemes and solvers"
    )


if __name__ == "__main__":
    main(work_precision)
