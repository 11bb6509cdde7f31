"""Assessments in the pipeline, of problems and schemes in files that the section ``assess`` names."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NotRequired

import xarray as xr
from typing_extensions import TypedDict

from study.assessment.assess import assess
from study.assessment.load import load
from study.pipeline.command import progress
from study.pipeline.experiment import Options, experiment
from study.pipeline.options import Name, Schemes, Size, Tolerances, section
from study.problem.definition import Problem
from study.scheme.base import Scheme


@section
class _Assessment(TypedDict):
    problem: str
    duration: NotRequired[Size]
    quantities: NotRequired[str]
    schemes: NotRequired[Schemes]
    own_schemes: NotRequired[list[str]]
    errors: NotRequired[Tolerances]


def _places(options: Options) -> list[tuple[str, str]]:
    """Keys and values that name something in a file."""
    places = [(key, options[key]) for key in ("problem", "quantities") if ".py" in options.get(key, "")]
    return places + [("own_schemes", place) for place in options.get("own_schemes", [])]


def _files(options: Options) -> Iterable[str]:
    return sorted({place.rpartition(":")[0] for _, place in _places(options)})


def _check(options: Options, configuration: Mapping) -> str | None:
    for key, place in _places(options):
        file, separator, _ = place.rpartition(":")
        if not separator or not file.endswith(".py"):
            return f"{key} must name a file and a name in it, such as model.py:frame, not {place!r}."
        if not Path(file).is_file():
            return f"{key} names the file '{file}', which is not there."
    return None


@experiment(
    "assessment",
    section="assess",
    model=dict[Name, _Assessment],
    split=lambda options: options,
    files=_files,
    check=_check,
    page="study.assessment.report",
    timed=True,
)
def assessment(
    problem: str,
    duration: float | None = None,
    quantities: str | None = None,
    schemes: Sequence[str] | None = None,
    own_schemes: Sequence[str] = (),
    errors: Sequence[float] = (0.1, 0.01, 0.001),
) -> xr.Dataset:
    """Assess a problem in a file, or one of the study: which scheme and which step it needs for an error.

    ``problem``, ``quantities`` and ``own_schemes`` name a :class:`study.Problem`, a dict of :class:`study.Quantity` and
    each a :class:`study.Scheme` as ``FILE.py:NAME``; ``problem`` may also be a name of the study.
    """
    progress(f"assessment of {problem}")
    chosen: dict[str, str | Scheme] = {name: name for name in schemes or ()}
    chosen |= {place.rpartition(":")[2]: load(place, (Scheme,)) for place in own_schemes}
    return assess(
        load(problem, (Problem,)) if ".py" in problem else problem,
        chosen or None,  # type: ignore[arg-type]
        duration=duration,
        quantities=load(quantities, (dict,)) if quantities else None,
        errors=errors,
    )
