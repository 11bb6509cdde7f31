"""The steps that make datasets, derived from the declarations of the experiments."""

import inspect
import json
from collections.abc import Callable, Iterable, Mapping

from pipeline.sources import Sources
from pipeline.step import Job, Step, job
from study.declaration.experiment import Experiment, Merged, Options, arguments_of
from study.declaration.options import names_in
from study.problem.named import makers
from study.scheme.named import schemes


def dataset(name: str) -> str:
    """Path of the file of a dataset."""
    return f"results/{name}.nc"


def named_in(experiment: Experiment, options: Options) -> dict[str, list[str]]:
    """Problems and schemes that the options of a job name; the type of an argument decides which values are names."""
    kinds = {name: kind for name, (kind, _) in arguments_of(experiment.function).items()}
    names: dict[str, list[str]] = {"problem": [], "scheme": []}
    for argument, value in options.items():
        for kind, name in names_in(kinds[argument], value):
            names[kind].append(name)
    return names


def _first_line(function: Callable) -> str:
    return (inspect.getdoc(function) or function.__name__).splitlines()[0].rstrip(".")


def _experiment_step(experiment: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step that runs an experiment, with a job for each set of options."""
    command = sources.root / "pipeline/command.py"
    folders = experiment.folders if experiment.along else experiment.makes
    outputs = tuple(dataset(f"{name}/{{job}}" if experiment.split else name) for name in folders)
    user_schemes = {place.rpartition(":")[2]: place for place in configuration.get("own_schemes", ())}

    def job_of(name: str, options: Options) -> Job:
        named = named_in(experiment, options)
        ours = [user_schemes[scheme] for scheme in named["scheme"] if scheme in user_schemes]
        modules = {type(schemes[scheme]).__module__ for scheme in named["scheme"] if scheme not in user_schemes}
        modules |= {makers[problem].__module__ for problem in named["problem"] if problem in makers}
        arguments = [
            "pipeline.command",
            *(f"--scheme={place}" for place in ours),
            experiment.module,
            experiment.makes[0],
        ]
        arguments += [*(output.replace("{job}", name) for output in outputs), json.dumps(options)]
        files = [
            *map(dataset, experiment.reads(options)),
            *experiment.files(options),
            *(place.rpartition(":")[0] for place in ours),
        ]
        # the command imports all schemes, but only the modules of the schemes in the options are inputs
        return job(arguments, [*files, command, *sources.of([experiment.module, *sorted(modules)])])

    return Step(
        name=experiment.name,
        message=_first_line(experiment.function),
        outputs=outputs,
        jobs={name: job_of(name, options) for name, options in experiment.jobs(configuration).items()},
        temporary=experiment.temporary or bool(experiment.along and not experiment.parts),
        alone=experiment.timed,
    )


def _gathered(name: str, dimensions: str, parts: Iterable[str], sources: Sources) -> Step:
    """The step that combines the datasets ``parts`` into the dataset ``name``."""
    files = [dataset(part) for part in parts]
    task = job(["pipeline.gather", dataset(name), dimensions, *files], [*files, *sources.of(["pipeline.gather"])])
    message = f"Dataset {name} from its {len(files)} parts"
    return Step(f"gathered_{name.replace('/', '_')}", message, (dataset(name),), {"": task}, quick=True)


def _drawn(experiment: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step that makes a page next to each dataset of an experiment."""
    names = list(experiment.jobs(configuration))
    files = {name: dataset(f"{experiment.makes[0]}/{name}") for name in names}
    output = f"results/{experiment.makes[0]}/{{job}}.html"
    jobs = {
        name: job([experiment.page, file, output.replace("{job}", name)], [file, *sources.of([experiment.page])])
        for name, file in files.items()
    }
    listed = {output: {name: (f"{experiment.name.capitalize()}s", name) for name in names}}
    return Step(f"{experiment.name}_page", f"Page of {experiment.name}", (output,), jobs, report=listed)


def steps_of(experiments: Iterable[Experiment | Merged], configuration: Mapping, sources: Sources) -> list[Step]:
    """The steps of all experiments, each followed by the steps that draw its pages and combine its datasets."""
    steps: list[Step] = []
    for experiment in experiments:
        if isinstance(experiment, Merged):
            steps.append(_gathered(experiment.makes, "none", experiment.of, sources))
            continue
        steps.append(_experiment_step(experiment, configuration, sources))
        if experiment.page:
            steps.append(_drawn(experiment, configuration, sources))
        if experiment.along:
            for name, folder in zip(experiment.makes, experiment.folders, strict=True):
                parts = [f"{folder}/{job}" for job in experiment.jobs(configuration)]
                steps.append(_gathered(name, experiment.along, parts, sources))
    return [step for step in steps if step.jobs]
