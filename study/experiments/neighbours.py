"""Accuracy of the schemes from starts one percent beside those of the springs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import xarray as xr

from study import io
from study.declaration.experiment import Options, experiment
from study.declaration.options import Schemes, Springs
from study.experiments import coordinates
from study.experiments.accuracy import errors_of
from study.problem.named import neighbouring_starts
from study.problem.named import problems as problems_by_name


def _options(configuration: Mapping) -> Options:
    """Runs of the schemes that are timed, which alone can be recommended."""
    return {
        "problems": configuration["recommendation"]["problems"],
        "schemes": configuration["work_precision"]["schemes"]["schemes"],
        "steps_per_period": configuration["accuracy"]["steps_per_period"],
        "periods": configuration["recommendation"]["periods"],
    }


def _number_of_steps(options: Options, configuration: Mapping) -> float:
    runs = len(neighbouring_starts) * len(options["problems"]) * len(options["schemes"])
    return runs * sum(options["steps_per_period"]) * sum(options["periods"])


def _reads(options: Options) -> list[str]:
    return [
        f"reference/neighbour/{problem}_{start}" for problem in options["problems"] for start in neighbouring_starts
    ]


@experiment(
    "neighbours",
    section="recommendation",
    options=_options,
    split=lambda options: {problem: {**options, "problems": [problem]} for problem in options["problems"]},
    along="problem",
    reads=_reads,
    steps=_number_of_steps,
)
def neighbours(
    problems: Springs, schemes: Schemes, steps_per_period: Sequence[int], periods: Sequence[int]
) -> xr.Dataset:
    """Measure what the dataset ``accuracy`` holds, from a start one percent below or above that of a spring.

    An error that a step keeps by accident, it does not keep from both. What a run yields has the shape
    (problem, start, scheme, steps_per_period, periods).

    Raises
    ------
    FileNotFoundError
        If the reference has not been made.
    """
    starts = {
        "start": ("start", list(neighbouring_starts), {"long_name": "start beside that of the problem"}),
        "multiple": (
            "start",
            list(neighbouring_starts.values()),
            {"long_name": "displacement at the start over that of the problem", "units": "1"},
        ),
    }
    found = []
    for problem in problems:
        own = problems_by_name[problem]
        motions = [
            (replace(own, u0=multiple * own.u0), io.open_dataset(f"reference/neighbour/{problem}_{start}"))
            for start, multiple in neighbouring_starts.items()
        ]
        errors = errors_of(motions, schemes, steps_per_period, periods)
        found.append(errors.rename(problem="start").expand_dims("problem").assign_coords(starts))
    return (
        xr.concat(found, "problem", data_vars="all")
        .assign_coords(coordinates.problem_coordinates(problems))
        .assign_attrs(title="Accuracy of the schemes from starts beside those of the springs")
    )
