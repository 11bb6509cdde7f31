"""The declaration of an experiment: the datasets that it makes and reads, its options, and its jobs.

This function, for example, is an experiment:

    @experiment("accuracy", reads=lambda o: [f"reference/{name}" for name in o["problems"]])
    def accuracy(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: Counts) -> xr.Dataset:

Its options are the section ``accuracy`` of the configuration, and its dataset is ``results/accuracy.nc``. The types of
its arguments set the bounds of the options (:mod:`study.declaration.options`).
"""

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, get_args, get_origin

Options = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Experiment:
    """An experiment of the study, or the computation of reference solutions.

    Attributes
    ----------
    makes
        Names of the datasets that the experiment makes.
    function
        Function of the options that returns the dataset, or a tuple of the datasets.
    section
        Dotted key of the configuration that holds the options. The section may be absent if all options have defaults.
    model
        Type of the section. By default, its keys and their types are the arguments of the function. If ``options`` is
        given without a ``model``, another experiment declares the section.
    options
        Function of the whole configuration that returns the options. By default, the options are the section.
    split
        Function of the options that returns the options of each job, by the job's name. Job ``x`` makes the dataset
        ``NAME/x`` for each ``NAME`` in ``makes``, or in ``parts`` if they are given. By default there is one job.
    along
        Dimensions, separated by commas, along which the datasets of all jobs are joined into the datasets ``makes``. If
        ``along`` is empty, the datasets of the jobs remain separate.
    parts
        Folders in which the datasets of the jobs are kept after they are joined, so that an interrupted experiment can
        continue.
    reads
        Function of a job's options that returns the names of the datasets that the job reads.
    files
        Function of a job's options that returns the paths of other files that the job reads.
    check
        Function of a job's options and the configuration that returns a sentence if the options contradict each other
        or the rest of the configuration, and ``None`` otherwise.
    page
        Module that makes a page of HTML next to each dataset. It is run with two arguments, the file of the dataset
        and the file of the page.
    timed
        Whether the experiment measures times, so that no other job may run at the same time.
    temporary
        Whether the datasets are removed once other datasets are made from them.
    """

    makes: tuple[str, ...]
    function: Callable
    section: str
    model: Any = None
    options: Callable[[Mapping], Options] | None = None
    split: Callable[[Options], Mapping[str, Options]] | None = None
    along: str = ""
    parts: tuple[str, ...] = ()
    reads: Callable[[Options], Iterable[str]] = lambda options: ()
    files: Callable[[Options], Iterable[str]] = lambda options: ()
    page: str = ""
    check: Callable[[Options, Mapping], str | None] = lambda options, configuration: None
    timed: bool = False
    temporary: bool = False

    @property
    def module(self) -> str:
        """The module that declares the experiment."""
        return self.function.__module__

    @property
    def name(self) -> str:
        """Name of the experiment's rule in the pipeline."""
        room, *_, last = self.module.split(".")
        return self.function.__name__ if room == "study" else f"{room}_{last}"

    def options_of(self, configuration: Mapping) -> Options:
        """The options in a complete configuration.

        Without ``options`` and ``model``, omitted options have the function's defaults.
        """
        if self.options is not None:
            return self.options(configuration)
        for key in self.section.split("."):
            configuration = configuration.get(key, {})
        return (self.defaults if self.model is None else {}) | dict(configuration)

    @property
    def defaults(self) -> Options:
        """The defaults of the function's arguments, by name; arguments without a default are left out."""
        return {name: default for name, (_, default) in arguments_of(self.function).items() if default is not ...}

    def jobs(self, configuration: Mapping) -> dict[str, Options]:
        """The options of every job, by the job's name; the name is empty if ``split`` is not given."""
        options = self.options_of(configuration)
        return {"": options} if self.split is None else dict(self.split(options))

    @property
    def named_jobs(self) -> bool:
        """Whether the names of the jobs are keys of the section; messages then name these keys."""
        return self.split is not None and not self.along and self.options is None

    @property
    def folders(self) -> tuple[str, ...]:
        """Folders of the datasets of the jobs, one folder for each dataset of the experiment."""
        return self.parts or self.makes


@dataclass(frozen=True, eq=False)
class Merged:
    """A dataset that is merged from several other datasets."""

    makes: str
    of: tuple[str, ...]


#: Folders of the results that hold products other than datasets.
_RESERVED = ("benchmarks", "figures", "logs", "tables")
#: Declarations in all imported modules. A key holds the name of the module, which is empty for merged datasets, and the
#: name of the first dataset.
DECLARED: dict[tuple[str, str], Experiment | Merged] = {}


def experiment(*makes: str, section: str = "", **declared: Any) -> Callable[[Callable], Callable]:
    """Declare that the decorated function is an experiment; the arguments are attributes of :class:`Experiment`.

    The default ``section`` is the name of the first dataset, with dots in place of slashes.

    Raises
    ------
    ValueError
        If the experiment makes no dataset, the name of a dataset or folder is invalid, or the module declares
        the first dataset twice.
    """
    if not makes or not all(isinstance(name, str) for name in makes):
        raise ValueError('an experiment must name the dataset that it makes: @experiment("name").')

    def declare(function: Callable) -> Callable:
        entry = Experiment(makes, function, section or makes[0].replace("/", "."), **declared)
        for name in (*makes, *entry.parts):
            if not re.fullmatch(r"[a-z0-9_]+(/[a-z0-9_]+)*", name) or name.split("/")[0] in _RESERVED:
                raise ValueError(
                    f"{entry.module} makes '{name}'; a dataset needs a name of small letters, digits and underscores, "
                    f"in folders other than {', '.join(_RESERVED)}."
                )
        if (entry.module, makes[0]) in DECLARED:
            raise ValueError(f"{entry.module} declares the dataset '{makes[0]}' twice; rename one of them.")
        DECLARED[entry.module, makes[0]] = entry
        return function

    return declare


def references(options: Options) -> list[str]:
    """Names of the reference datasets of the option ``problems``; a function for the attribute ``reads``."""
    return [f"reference/{problem}" for problem in options["problems"]]


def merged(makes: str, of: Sequence[str]) -> None:
    """Declare a dataset that is merged from other datasets."""
    DECLARED["", makes] = Merged(makes, tuple(of))


#: Packages whose modules declare experiments.
PACKAGES = ("reference.experiments", "study.experiments", "study.assessment", "study.runs")


def discover() -> list[Experiment | Merged]:
    """All experiments and merged datasets that the modules of ``PACKAGES`` declare."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        for module in pkgutil.iter_modules(package.__path__, f"{name}."):
            importlib.import_module(module.name)
    return list(DECLARED.values())


def _has_plain_strings(kind: Any) -> bool:
    """Whether a type has values that are strings without a mark; the keys of a dict do not count."""
    parts = get_args(kind)[1:] if get_origin(kind) is dict else get_args(kind)
    return kind is str or (get_origin(kind) is not Annotated and any(map(_has_plain_strings, parts)))


def arguments_of(function: Callable) -> dict[str, tuple[Any, Any]]:
    """Type and default of each argument of a function, as pydantic defines fields; ``...`` marks a missing default.

    Raises
    ------
    ValueError
        If an argument has no type, or its type has plain strings.
    """
    parameters = inspect.signature(function, eval_str=True).parameters
    for name, parameter in parameters.items():
        if parameter.annotation is parameter.empty or parameter.kind is parameter.VAR_KEYWORD:
            raise ValueError(
                f"{function.__module__}: the argument '{name}' of '{function.__name__}' needs a type, which bounds its "
                "option in the configuration."
            )
        if _has_plain_strings(parameter.annotation):
            raise ValueError(
                f"{function.__module__}: the argument '{name}' of '{function.__name__}' needs a type of "
                "study.declaration.options, such as ProblemName, SchemeName or Name, which determines the job's files."
            )
    return {
        name: (parameter.annotation, ... if parameter.default is parameter.empty else parameter.default)
        for name, parameter in parameters.items()
    }


def progress(message: str) -> None:
    """Print what a job works on, without delay."""
    print(message, flush=True)
