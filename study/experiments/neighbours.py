"""Accuracy of the schemes from starts one percent beside those of the springs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import xarray as xr

from study import datasets
from study.experiments.accuracy import errors_of
from study.pipeline import coordinates
from study.pipeline.experiment import Options, experiment
from study.problem.named import neighbouring_starts, problems


def _options(configuration: Mapping) -> Options:
    """Runs of the schemes that are timed, which alone can be recommended."""
    return {
        "problems": configuration["recommendation"]["problems"],
        "schemes": configuration["work_precision"]["schemes"]["schemes"],
        "steps_per_period": configuration["accuracy"]["steps_per_period"],
        "periods": configuration["recommendation"]["periods"],
    }


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem and start."""
    shared = {key: options[key] for key in ("schemes", "steps_per_period", "periods")}
    return {
        f"{problem}_{start}": {"problem": problem, "start": start, **shared}
        for problem in options["problems"]
        for start in neighbouring_starts
    }


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    return len(options["schemes"]) * sum(options["steps_per_period"]) * sum(options["periods"])


@experiment(
    "neighbours",
    section="recommendation",
    options=_options,
    split=_jobs,
    along="problem,start",
    reads=lambda options: [f"reference/neighbour/{options['problem']}_{options['start']}"],
    steps=_number_of_steps,
)
def neighbours(
    problem: str, start: str, schemes: Sequence[str], steps_per_period: Sequence[int], periods: Sequence[int]
) -> xr.Dataset:
    """Measure what the dataset ``accuracy`` holds, from a start one percent below or above that of a spring.

    An error that a step keeps by accident, it does not keep from both. Each variable has the shape
    (problem, start, scheme, steps_per_period, periods).

    Raises
    ------
    FileNotFoundError
        If the reference has not been made.
    """
    multiple, own = neighbouring_starts[start], problems[problem]
    motion = replace(own, u0=multiple * own.u0), datasets.open(f"reference/neighbour/{problem}_{start}")
    about = {"long_name": "displacement at the start over that of the problem", "units": "1"}
    return (
        errors_of([motion], schemes, steps_per_period, periods)
        .expand_dims("start", axis=1)
        .assign_coords(
            coordinates.problem_coordinates([problem])
            | {
                "start": ("start", [start], {"long_name": "start beside that of the problem"}),
                "multiple": ("start", [multiple], about),
            }
        )
        .assign_attrs(title="Accuracy of the schemes from starts beside those of the springs")
    )
