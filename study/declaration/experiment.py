"""The declaration of an experiment: the datasets that it makes and reads, its options, and the work of its jobs.

    @experiment("accuracy", reads=lambda o: [f"reference/{name}" for name in o["problems"]])
    def accuracy(problems: Springs, schemes: Schemes, steps_per_period: Counts, periods: Counts) -> xr.Dataset:

is an experiment whose options are the section ``accuracy`` of the configuration and whose dataset is
``results/accuracy.nc``. The types of the arguments bound the options (:mod:`study.declaration.options`).
"""

import importlib
import inspect
import math
import pkgutil
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Options = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Experiment:
    """An experiment of the study, or the computation of reference solutions.

    Attributes
    ----------
    makes
        Names of the datasets in the results.
    function
        Function of the options that returns the datasets, one or a tuple.
    section
        Dotted key of the configuration that holds the options. The section may be absent if all options have defaults.
    model
        Type of the section; by default it has the arguments of the function. If there are ``options`` and no ``model``,
        another experiment declares the section.
    options
        Function that takes the options from the whole configuration, if they are not the section.
    split
        Function from the options to the options of each job, by the job's name. The datasets of job ``x`` are
        ``makes/x``.
    along
        Dimensions, separated by commas, along which the datasets of all jobs are joined to ``makes``. If it is empty,
        they remain separate.
    parts
        Folders in which the datasets of the jobs are kept, so that an interrupted experiment can continue.
    reads
        Function of a job's options that returns the names of the datasets that the job reads.
    files
        Function of a job's options that returns other files that the job reads.
    check
        Function that returns a sentence if the options contradict each other or the rest of the configuration, and
        ``None`` otherwise.
    steps, values
        Functions that return the approximate number of steps of all runs of a job, and of values in its memory.
    page
        Module that makes a page of HTML next to each dataset. Its arguments are the files of the dataset and the page.
    stops_early
        Whether a job may end as soon as its runs decide the result; ``steps`` is then an upper bound.
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
    steps: Callable[[Options, Mapping], float] = lambda options, configuration: 0
    values: Callable[[Options, Mapping], float] = lambda options, configuration: 0
    stops_early: bool = False
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
        """The options in a complete configuration; without a ``model``, omitted ones have the function's defaults."""
        if self.options is not None:
            return self.options(configuration)
        for key in self.section.split("."):
            configuration = configuration.get(key, {})
        return (self.defaults if self.model is None else {}) | dict(configuration)

    @property
    def defaults(self) -> Options:
        """The default of each argument of the function that has one."""
        return {name: default for name, (_, default) in arguments_of(self.function).items() if default is not ...}

    def jobs(self, configuration: Mapping) -> dict[str, Options]:
        """The options of every job, by the job's name, which is empty if there is only one job."""
        options = self.options_of(configuration)
        return {"": options} if self.split is None else dict(self.split(options))

    @property
    def named_jobs(self) -> bool:
        """Whether the jobs are keys of the section; messages then name the key."""
        return self.split is not None and not self.along and self.options is None

    @property
    def folders(self) -> tuple[str, ...]:
        """Folders of the datasets of the jobs, one for each dataset."""
        return self.parts or self.makes


@dataclass(frozen=True, eq=False)
class Merged:
    """A dataset that is merged from several other datasets."""

    makes: str
    of: tuple[str, ...]


#: Folders of the results that hold other products.
_RESERVED = ("benchmarks", "figures", "logs", "tables")
#: Declarations in all imported modules, by module and first dataset.
DECLARED: dict[tuple[str, str], Experiment | Merged] = {}


def experiment(*makes: str, section: str = "", **declared: Any) -> Callable[[Callable], Callable]:
    """Declare the decorated function an experiment; the arguments are the attributes of :class:`Experiment`.

    Raises
    ------
    ValueError
        If the experiment makes no dataset, the name of a dataset is invalid, or the module declares a dataset twice.
    """
    if not makes or not all(isinstance(name, str) for name in makes):
        raise ValueError('an experiment must name the dataset that it makes: @experiment("name").')

    def declare(function: Callable) -> Callable:
        one = Experiment(makes, function, section or makes[0].replace("/", "."), **declared)
        for name in (*makes, *one.parts):
            if not re.fullmatch(r"[a-z0-9_]+(/[a-z0-9_]+)*", name) or name.split("/")[0] in _RESERVED:
                raise ValueError(
                    f"{one.module} makes '{name}'; a dataset needs a name of small letters, digits and underscores, in "
                    f"folders other than {', '.join(_RESERVED)}."
                )
        if (one.module, makes[0]) in DECLARED:
            raise ValueError(f"{one.module} declares the dataset '{makes[0]}' twice; rename one of them.")
        DECLARED[one.module, makes[0]] = one
        return function

    return declare


def references(options: Options) -> list[str]:
    """The datasets of exact motions of the problems of an experiment, which reads them."""
    return [f"reference/{problem}" for problem in options["problems"]]


def over_periods(*lists: str, runs: int = 1) -> Callable[[Options, Mapping], float]:
    """Number of steps if ``runs`` runs over whole periods are made for all items of some options and all step sizes."""

    def steps(options: Options, configuration: Mapping) -> float:
        of_each = sum(options["steps_per_period"]) * np.sum(options["periods"])
        return float(runs * math.prod(len(options[name]) for name in lists) * of_each)

    return steps


def merged(makes: str, of: Sequence[str]) -> None:
    """Declare a dataset that is merged from other datasets."""
    DECLARED["", makes] = Merged(makes, tuple(of))


#: Packages whose modules declare experiments.
PACKAGES = ("reference.experiments", "study.experiments", "study.assessment")


def discover() -> list[Experiment | Merged]:
    """All experiments that modules declare."""
    for name in PACKAGES:
        package = importlib.import_module(name)
        for module in pkgutil.iter_modules(package.__path__, f"{name}."):
            importlib.import_module(module.name)
    return list(DECLARED.values())


def arguments_of(function: Callable) -> dict[str, tuple[Any, Any]]:
    """Types and defaults of the arguments of a function, as pydantic's fields; ``...`` marks a missing default."""
    parameters = inspect.signature(function, eval_str=True).parameters
    for name, one in parameters.items():
        if one.annotation is one.empty or one.kind is one.VAR_KEYWORD:
            raise ValueError(
                f"{function.__module__}: the argument '{name}' of '{function.__name__}' needs a type, which bounds its "
                "option in the configuration."
            )
        if one.annotation in (str, list[str], Sequence[str]):
            raise ValueError(
                f"{function.__module__}: the argument '{name}' of '{function.__name__}' needs a type of "
                "study.declaration.options, such as ProblemName, SchemeName or Name, which determines the job's files."
            )
    return {
        name: (one.annotation, ... if one.default is one.empty else one.default) for name, one in parameters.items()
    }


def progress(message: str) -> None:
    """Print what a job works on, without delay."""
    print(message, flush=True)
