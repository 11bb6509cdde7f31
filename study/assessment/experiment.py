"""Assessments in the pipeline.

The section ``assess`` of the configuration lists the problems: problems of the study, or your own problems in files.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NotRequired

import xarray as xr
from typing_extensions import TypedDict

from study import io
from study.assessment.arguments import USUAL
from study.assessment.assess import assess
from study.assessment.periods import length_of
from study.declaration.experiment import Options, experiment, progress
from study.declaration.options import Count, Name, Place, ProblemPlace, Schemes, Size, Tolerances, section
from study.mechanics.definition import Problem
from study.problem.named import problems
from study.registry import UnknownName
from study.user_files import load


@section
class _Assessment(TypedDict):
    problem: ProblemPlace
    duration: NotRequired[Size]
    periods: NotRequired[Count]
    quantities: NotRequired[Place]
    schemes: NotRequired[Schemes]
    allowed_errors: NotRequired[Tolerances]
    maps: NotRequired[bool]


def _places(options: Options) -> list[tuple[str, str]]:
    """The options whose value is ``FILE.py:NAME``, as pairs of key and value."""
    return [(key, options[key]) for key in ("problem", "quantities") if ".py" in options.get(key, "")]


def _files(options: Options) -> Iterable[str]:
    return sorted({place.rpartition(":")[0] for _, place in _places(options)})


def _reads(options: Options) -> list[str]:
    """Name of the dataset with the spring's exact period, in a list; empty if the options do not give ``periods``."""
    return [f"reference/{options['problem']}"] if "periods" in options else []


def _check(options: Options, configuration: Mapping) -> str | None:
    if {"duration", "periods"} <= options.keys():
        return "periods: duration already gives the length of the runs; leave one of them out."
    for key, place in _places(options):
        file, separator, _ = place.rpartition(":")
        if not separator or not file.endswith(".py"):
            return f"{key} must name a file and a name in it, such as model.py:frame, not {place!r}."
        if not Path(file).is_file():
            return f"{key} names the file '{file}', which does not exist."
    try:
        problem = _problem(options["problem"])
        if "periods" not in options:
            length_of(problem, options.get("duration"))
        if "quantities" in options:
            load(options["quantities"], (dict,))
    except (UnknownName, ValueError) as error:
        return str(error)
    return None


def _jobs(options: Options) -> dict[str, Options]:
    """The options of each job; if they name no schemes, the names of the default schemes are added.

    The pipeline needs these names, because the files that a job reads follow from them.
    """
    return {name: {"schemes": list(USUAL)} | job for name, job in options.items()}


def _problem(place: str) -> Problem:
    return load(place, (Problem,)) if ".py" in place else problems[place]


@experiment(
    "assessment",
    section="assess",
    model=dict[Name, _Assessment],
    split=_jobs,
    reads=_reads,
    files=_files,
    check=_check,
    page="study.assessment.report",
    timed=True,
)
def assessment(
    problem: ProblemPlace,
    duration: float | None = None,
    periods: int | None = None,
    quantities: Place | None = None,
    schemes: Schemes | None = None,
    allowed_errors: Sequence[float] = (0.1, 0.01, 0.001),
    maps: bool = True,
) -> xr.Dataset:
    """Assess which scheme and which step a problem of the study, or one in a file, needs for an error.

    ``problem`` and ``quantities`` name a :class:`study.Problem` and a dict of :class:`study.Quantity` as
    ``FILE.py:NAME``; ``problem`` may also be a name of the study. ``periods`` is the duration of the runs of
    a spring, as a multiple of its exact period. The dataset ``reference/PROBLEM`` contains the exact period.
    """
    progress(f"assessment of {problem}")
    if periods is not None:
        duration = periods * io.open_dataset(f"reference/{problem}").period.item()
    assessed = assess(
        _problem(problem),
        schemes,
        duration=duration,
        quantities=load(quantities, (dict,)) if quantities else None,
        allowed_errors=allowed_errors,
        maps=maps,
    )
    for name in ("date_created", "history"):  # the pipeline adds reproducible ones
        del assessed.attrs[name]
    return assessed if periods is None else assessed.assign_attrs(periods=periods)
