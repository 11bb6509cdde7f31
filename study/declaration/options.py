"""Types of the options of experiments, with their bounds.

The arguments of an experiment have these types. The check of the configuration and its schema follow from the types.
Every job of the pipeline imports this module, so it does not import pydantic, which takes a quarter of a second.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from annotated_types import Ge, Gt, Le, Len, Lt
from typing_extensions import TypedDict, is_typeddict


def section(kind: type) -> type:
    """Mark a TypedDict as a section of the configuration: only its keys are accepted, with values of their types."""
    kind.__pydantic_config__ = {"extra": "forbid", "strict": True}  # type: ignore[attr-defined]
    return kind


@dataclass(frozen=True)
class Checked:
    """A check of the value of an option, made after the checks of its type and bounds.

    Parameters
    ----------
    function
        Function of a value and the registries of names by kind. It returns the value, or raises a ``ValueError``.
    """

    function: Callable[[Any, Mapping[str, Any]], Any]

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable) -> Any:
        """The validation schema, for pydantic."""
        from pydantic_core import core_schema

        def check(value, info):
            return self.function(value, info.context)

        return core_schema.with_info_after_validator_function(check, handler(source))


def _distinct(values: list, registries: Mapping[str, Any]) -> list:
    for value in values:
        if values.count(value) > 1:
            raise ValueError(f"{value!r} is listed twice")
    return values


def _listed(kind: str) -> Checked:
    """A check that a name is in the registry of this kind, in the spelling that datasets and files use."""

    def check(name: str, registries: Mapping[str, Any]) -> str:
        try:
            registered = registries[kind].resolve(name)
        except KeyError as error:
            raise ValueError(str(error.args[0]).rstrip(".")) from None
        if name != registered:
            raise ValueError(f"write '{registered}', the name in the datasets, instead of '{name}'")
        return name

    return Checked(check)


def _plain(name: str, registries: Mapping[str, Any]) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ValueError(f"{name!r} must be a name of small letters, digits and underscores")
    return name


def _in_order(span: dict, registries: Mapping[str, Any]) -> dict:
    if not span["first"] < span["last"]:
        raise ValueError(f"first, {span['first']}, must be less than last, {span['last']}")
    return span


def _falling(values: list, registries: Mapping[str, Any]) -> list:
    if values != sorted(values, reverse=True):
        raise ValueError(f"must be in descending order, not {values}")
    return values


def rising(values: list, registries: Mapping[str, Any]) -> list:
    """Refuse values that are not in ascending order."""
    if values != sorted(values):
        raise ValueError(f"must be in ascending order, not {values}")
    return values


@dataclass(frozen=True)
class Names:
    """Mark in the type of a string: it names a ``problem`` or ``scheme``, whose source file is an input of the job."""

    kind: str


_FEW = Len(1, 1000)
_DISTINCT = Checked(_distinct)
#: Check that ``first`` is less than ``last``.
IN_ORDER = Checked(_in_order)

#: Relative damping of linear oscillators.
DampingRatios = Annotated[list[Annotated[float, Ge(0), Lt(1)]], Len(1, 100), _DISTINCT]
#: A number of steps, periods or repeats.
Count = Annotated[int, Ge(1), Le(10_000_000)]
#: Number of steps of a run that stores every step.
RecordedSteps = Annotated[int, Ge(1), Le(1_000_000)]
#: Number of repeats of a timing or run.
Repeats = Annotated[int, Ge(1), Le(1000)]
#: Number of values along an axis of a dataset.
Length = Annotated[int, Ge(2), Le(10_000)]
#: A time, a step size or a displacement, from 1e-9 to 1e9.
Size = Annotated[float, Ge(1e-9), Le(1e9)]
#: A relative tolerance, error or perturbation.
Tolerance = Annotated[float, Ge(1e-15), Lt(1)]
Counts = Annotated[list[Count], _FEW, _DISTINCT]
#: Number of records of ground motion.
Records = Annotated[int, Ge(1), Le(1000)]
#: Periods in s of oscillators under records of ground motion.
RecordPeriods = Annotated[list[Annotated[float, Ge(0.05), Le(10)]], _FEW, _DISTINCT]
#: Ratios of the largest elastic force to the strength of an oscillator.
Reductions = Annotated[list[Annotated[float, Ge(1), Le(100)]], _FEW, _DISTINCT]
#: Duration of a record of ground motion in s.
RecordDuration = Annotated[float, Ge(1), Le(100)]
RisingCounts = Annotated[list[Count], _FEW, _DISTINCT, Checked(rising)]
Sizes = Annotated[list[Size], _FEW, _DISTINCT]
Tolerances = Annotated[list[Tolerance], _FEW, _DISTINCT]
#: Allowed errors in descending order.
FallingErrors = Annotated[list[Tolerance], _FEW, _DISTINCT, Checked(_falling)]
#: Tolerances of solvers in descending order, at most 0.1 because larger tolerances lose the motion.
FallingTolerances = Annotated[list[Annotated[float, Ge(1e-15), Le(0.1)]], _FEW, _DISTINCT, Checked(_falling)]

#: A name that is valid as the name of a file.
Name = Annotated[str, Checked(_plain)]
PlainNames = Annotated[list[Name], _FEW, _DISTINCT]
#: Place of a Python object in a file, as FILE.py:NAME.
Place = Annotated[str, Len(1, 1000)]
#: Path of a folder, relative to the working folder.
Folder = Annotated[str, Len(1, 1000)]
#: Name of a problem, or place of a problem in a file, as FILE.py:NAME.
ProblemPlace = Annotated[str, Len(1, 1000), Names("problem")]
#: Name of any problem.
ProblemName = Annotated[str, _listed("problem"), Names("problem")]
#: Name of a free oscillator of one unknown with known period.
Spring = Annotated[str, _listed("spring"), Names("problem")]
#: Name of a structure with a time scale.
Structure = Annotated[str, _listed("structure"), Names("problem")]
#: Name of a problem whose exact displacement is known.
KnownProblem = Annotated[str, _listed("problem with a known displacement"), Names("problem")]
#: Name of a scheme.
SchemeName = Annotated[str, _listed("scheme"), Names("scheme")]
#: Name of a one-step scheme. Such a scheme adds increments to displacement and velocity; the sums can be compensated.
OneStepName = Annotated[SchemeName, _listed("one-step scheme")]
Springs = Annotated[list[Spring], _FEW, _DISTINCT]
Problems = Annotated[list[ProblemName], _FEW, _DISTINCT]
#: Name of a problem whose force has kinks or a memory, or whose load has kinks. ``hardening`` is a smooth problem for
#: comparison.
KinkedName = Annotated[Literal["hardening", "yielding", "hysteretic", "bouncing", "shaken", "pulse"], Names("problem")]
Kinked = Annotated[list[KinkedName], _FEW, _DISTINCT]
#: Names of problems with samples of the exact motion: problems of ``KinkedName``, and structures.
Sampled = Annotated[list[KinkedName | Structure], _FEW, _DISTINCT]
Schemes = Annotated[list[SchemeName], _FEW, _DISTINCT]
Estimators = Annotated[list[Annotated[str, _listed("estimator")]], _FEW, _DISTINCT]
ControllerName = Annotated[str, _listed("controller")]
Controllers = Annotated[list[ControllerName], _FEW, _DISTINCT]
#: Schemes in files of a user, each as FILE.py:NAME.
OwnSchemes = Annotated[list[str], Len(0, 1000), _DISTINCT]
OneStepSchemes = Annotated[list[OneStepName], _FEW, _DISTINCT]


@section
class _Numbers(TypedDict):
    first: Annotated[float, Ge(-1e6), Le(1e6)]
    last: Annotated[float, Ge(-1e6), Le(1e6)]
    count: Length


@section
class _StepSizes(TypedDict):
    first: Size
    last: Size
    count: Length


@section
class _PowersOfTen(TypedDict):
    first: Annotated[float, Ge(-9), Le(9)]
    last: Annotated[float, Ge(-9), Le(9)]
    count: Length


#: ``count`` evenly spaced numbers from ``first`` to ``last``.
Numbers = Annotated[_Numbers, IN_ORDER]
#: ``count`` evenly spaced step sizes from ``first`` to ``last``.
StepSizes = Annotated[_StepSizes, IN_ORDER]
#: ``count`` powers of ten, whose exponents are evenly spaced from ``first`` to ``last``.
PowersOfTen = Annotated[_PowersOfTen, IN_ORDER]


@section
class StructureLength(TypedDict):
    """Duration of a run of a structure, as a multiple of its time scale."""

    problem: Structure
    periods: Annotated[float, Gt(0), Le(10_000)]


def _each_once(lengths: list, registries: Mapping[str, Any]) -> list:
    return _distinct([length["problem"] for length in lengths], registries) and lengths


StructureLengths = Annotated[list[StructureLength], Len(1, 1000), Checked(_each_once)]


def names_in(kind: Any, value: Any) -> Iterator[tuple[str, str]]:
    """Pairs of kind and name of the problems and schemes in an option's value, found by the marks in its type."""
    if get_origin(kind) is Annotated:
        kind, *notes = get_args(kind)
        yield from ((note.kind, value) for note in notes if isinstance(note, Names) and isinstance(value, str))
    if get_origin(kind) in (Union, UnionType):
        yield from dict.fromkeys(pair for member in get_args(kind) for pair in names_in(member, value))
    elif isinstance(value, list):
        for item in value:
            yield from names_in((get_args(kind) or (None,))[0], item)
    elif isinstance(value, dict):
        fields = get_type_hints(kind, include_extras=True) if is_typeddict(kind) else {}
        value_type = get_args(kind)[1] if get_origin(kind) is dict else None
        for key, item in value.items():
            yield from names_in(fields.get(key, value_type), item)
