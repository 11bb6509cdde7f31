"""The steps of the pipeline: what each makes of what by which command, derived from what experiments declare."""

import inspect
import json
import shlex
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from study.pipeline.experiment import Experiment, Merged, Options
from study.pipeline.own_schemes import file_of, own_schemes_in
from study.pipeline.sources import Sources, modules_of_schemes, schemes_in


@dataclass(frozen=True)
class Job:
    """One command of a step, and the files that it needs."""

    command: str
    inputs: tuple[str, ...]


@dataclass(frozen=True)
class Step:
    """Jobs of one kind, which become one rule.

    Attributes
    ----------
    name, message
        What the rule is called, and what it says when it starts.
    outputs
        Files that it makes, with the place of ``{job}`` where there are several jobs.
    jobs
        The jobs by name, which is empty where there is only one.
    temporary
        Whether the outputs are removed once they have been used.
    alone
        Whether nothing else may run beside it, as it measures times.
    quick
        Whether its jobs take seconds, so that none of them is worth a place on a cluster.
    report
        What the report of the pipeline lists: by output, and by the name of the job, the heading and the label there.
    """

    name: str
    message: str
    outputs: tuple[str, ...]
    jobs: Mapping[str, Job]
    temporary: bool = False
    alone: bool = False
    quick: bool = False
    report: Mapping[str, Mapping[str, tuple[str, str]]] = field(default_factory=dict)


def dataset(name: str) -> str:
    """The file of a dataset."""
    return f"results/{name}.nc"


def command(module: str, *arguments: Any, environment: Mapping[str, str] | None = None) -> str:
    """A command that runs a module."""
    settings = [f"{name}={value}" for name, value in (environment or {}).items()]
    return (
        shlex.join(["env", *settings] if settings else [])
        + " " * bool(settings)
        + shlex.join(["python", "-m", module, *map(str, arguments)])
    )


def _first_line(function: Callable) -> str:
    """What a function says of itself in one line."""
    return (inspect.getdoc(function) or function.__name__).splitlines()[0].rstrip(".")


def _made_by(one: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step of an experiment."""
    folders = one.folders if one.along else one.makes
    outputs = tuple(dataset(f"{name}/{{job}}" if one.split else name) for name in folders)

    def job(name: str, options: Options) -> Job:
        made = [output.replace("{job}", name) for output in outputs]
        own = own_schemes_in(options, configuration)
        modules = [one.module, "study.pipeline.command", *modules_of_schemes(schemes_in(options) - own.keys())]
        runner = ["study.pipeline.own_schemes", shlex.join(own.values())] if own else ["study.pipeline.command"]
        text = command(*runner, one.module, one.makes[0], *made, json.dumps(options), environment=one.environment)
        files = *one.files(options), *map(file_of, own.values()), *map(str, sources.of(*modules))
        return Job(text, (*map(dataset, one.reads(options)), *files))

    return Step(
        name=one.name,
        message=_first_line(one.function),
        outputs=outputs,
        jobs={name: job(name, options) for name, options in one.jobs(configuration).items()},
        temporary=one.temporary or bool(one.along and not one.parts),
        alone=one.timed,
    )


def _gathered(name: str, dimensions: str, parts: Iterable[str], sources: Sources) -> Step:
    """The step that puts datasets together."""
    files = [dataset(part) for part in parts]
    return Step(
        name=f"gathered_{name.replace('/', '_')}",
        message=f"Dataset {name} of its {len(files)} parts",
        outputs=(dataset(name),),
        jobs={
            "": Job(
                command("study.pipeline.gather", dataset(name), dimensions, *files),
                (*files, *map(str, sources.of("study.pipeline.gather"))),
            )
        },
        quick=True,
    )


def _page(name: str) -> str:
    """The page beside a dataset."""
    return f"results/{name}.html"


def pages_of(experiments: Iterable[Experiment | Merged], configuration: Mapping) -> list[str]:
    """The pages that experiments make beside their datasets."""
    with_pages = [one for one in experiments if isinstance(one, Experiment) and one.page]
    return [_page(f"{one.makes[0]}/{job}") for one in with_pages for job in one.jobs(configuration)]


def _drawn(one: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step that makes the pages of an experiment."""

    def job(name: str) -> Job:
        files = dataset(f"{one.makes[0]}/{name}"), _page(f"{one.makes[0]}/{name}")
        return Job(command(one.page, *files), (files[0], *map(str, sources.of(one.page))))

    jobs = {name: job(name) for name in one.jobs(configuration)}
    output = _page(f"{one.makes[0]}/{{job}}")
    listed = {output: {name: (f"{one.name.capitalize()}s", name) for name in jobs}}
    return Step(f"{one.name}_page", f"Page of {one.name}", (output,), jobs, report=listed)


def steps_of(experiments: Iterable[Experiment | Merged], configuration: Mapping, sources: Sources) -> list[Step]:
    """The steps of all experiments, each followed by what puts the datasets of its jobs together."""
    steps: list[Step] = []
    for one in experiments:
        if isinstance(one, Merged):
            steps.append(_gathered(one.makes, "none", one.of, sources))
            continue
        steps.append(_made_by(one, configuration, sources))
        if one.page:
            steps.append(_drawn(one, configuration, sources))
        if one.along:
            for name, folder in zip(one.makes, one.folders, strict=True):
                parts = [f"{folder}/{job}" for job in one.jobs(configuration)]
                steps.append(_gathered(name, one.along, parts, sources))
    return [step for step in steps if step.jobs]
