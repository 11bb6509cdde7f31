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


def named_in(one: Experiment, options: Options) -> dict[str, list[str]]:
    """Problems and schemes that the options of a job name; the type of an argument decides which values are names."""
    kinds = {name: kind for name, (kind, _) in arguments_of(one.function).items()}
    found: dict[str, list[str]] = {"problem": [], "scheme": []}
    for argument, value in options.items():
        for kind, name in names_in(kinds[argument], value):
            found[kind].append(name)
    return found


def _first_line(function: Callable) -> str:
    return (inspect.getdoc(function) or function.__name__).splitlines()[0].rstrip(".")


def _made_by(one: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step that runs an experiment, with a job for each set of options."""
    command = sources.root / "pipeline/command.py"
    folders = one.folders if one.along else one.makes
    outputs = tuple(dataset(f"{name}/{{job}}" if one.split else name) for name in folders)
    own = {place.rpartition(":")[2]: place for place in configuration.get("own_schemes", ())}

    def job_of(name: str, options: Options) -> Job:
        named = named_in(one, options)
        ours = [own[scheme] for scheme in named["scheme"] if scheme in own]
        modules = {type(schemes[scheme]).__module__ for scheme in named["scheme"] if scheme not in own}
        modules |= {makers[problem].__module__ for problem in named["problem"] if problem in makers}
        arguments = ["pipeline.command", *(f"--scheme={place}" for place in ours), one.module, one.makes[0]]
        arguments += [*(output.replace("{job}", name) for output in outputs), json.dumps(options)]
        files = [*map(dataset, one.reads(options)), *one.files(options), *(place.rpartition(":")[0] for place in ours)]
        # the command imports all schemes, but only the modules of the schemes in the options are inputs
        return job(arguments, [*files, command, *sources.of([one.module, *sorted(modules)])])

    return Step(
        name=one.name,
        message=_first_line(one.function),
        outputs=outputs,
        jobs={name: job_of(name, options) for name, options in one.jobs(configuration).items()},
        temporary=one.temporary or bool(one.along and not one.parts),
        alone=one.timed,
    )


def _gathered(name: str, dimensions: str, parts: Iterable[str], sources: Sources) -> Step:
    """The step that combines the datasets ``parts`` into the dataset ``name``."""
    files = [dataset(part) for part in parts]
    one = job(["pipeline.gather", dataset(name), dimensions, *files], [*files, *sources.of(["pipeline.gather"])])
    message = f"Dataset {name} from its {len(files)} parts"
    return Step(f"gathered_{name.replace('/', '_')}", message, (dataset(name),), {"": one}, quick=True)


def _drawn(one: Experiment, configuration: Mapping, sources: Sources) -> Step:
    """The step that makes a page next to each dataset of an experiment."""
    names = list(one.jobs(configuration))
    files = {name: dataset(f"{one.makes[0]}/{name}") for name in names}
    output = f"results/{one.makes[0]}/{{job}}.html"
    jobs = {
        name: job([one.page, file, output.replace("{job}", name)], [file, *sources.of([one.page])])
        for name, file in files.items()
    }
    listed = {output: {name: (f"{one.name.capitalize()}s", name) for name in names}}
    return Step(f"{one.name}_page", f"Page of {one.name}", (output,), jobs, report=listed)


def steps_of(experiments: Iterable[Experiment | Merged], configuration: Mapping, sources: Sources) -> list[Step]:
    """The steps of all experiments, each followed by the steps that draw its pages and combine its datasets."""
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
