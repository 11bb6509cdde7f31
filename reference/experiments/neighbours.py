"""Exact motions of springs that start one percent beside their own start: ``reference/neighbour/PROBLEM_START``."""

from collections.abc import Mapping, Sequence

import xarray as xr

from reference.experiments.springs import numbers_held, over_one_period
from study.declaration.experiment import Options, experiment
from study.declaration.options import Name, Spring
from study.problem.named import neighbouring_starts


def _options(configuration: Mapping) -> Options:
    return {
        "problems": configuration["recommendation"]["problems"],
        "steps_per_period": configuration["accuracy"]["steps_per_period"],
    }


def _jobs(options: Options) -> dict[str, Options]:
    """The options of one job for each problem and start."""
    return {
        f"{problem}_{name}": {"problem": problem, "start": name, "steps_per_period": options["steps_per_period"]}
        for problem in options["problems"]
        for name in neighbouring_starts
    }


@experiment("reference/neighbour", section="recommendation", options=_options, split=_jobs, values=numbers_held)
def neighbour(problem: Spring, start: Name, steps_per_period: Sequence[int]) -> xr.Dataset:
    """Compute period and motion of a spring that starts one percent below or above its own start.

    The dataset is like that of :func:`reference.experiments.springs.reference`.

    Raises
    ------
    RouteFailed
        If the integrations do not agree.
    """
    return over_one_period(problem, neighbouring_starts[start], steps_per_period)
