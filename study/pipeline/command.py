"""How the pipeline runs an experiment: ``python -m study.pipeline.command MODULE DATASET OUTPUT... 'JSON OPTIONS'``."""

import gc
import importlib
import json
import sys

import xarray as xr

from study import datasets
from study.datasets import provenance, write
from study.pipeline.experiment import DECLARED, Experiment, arguments_of
from study.registry import did_you_mean
from study.writing import NotWritten, check_writable


def _options(experiment: Experiment, text: str) -> dict:
    """Options of an experiment out of a JSON object, refused with a sentence when they do not fit."""
    try:
        options = json.loads(text)
    except json.JSONDecodeError as error:
        raise SystemExit(f"the options must be a JSON object: {error}.") from None
    if not isinstance(options, dict):
        raise SystemExit(f"the options must be a JSON object, not {text}.")
    known = arguments_of(experiment.function)
    for name in options:
        if name not in known:
            raise SystemExit(f"there is no option '{name}'; {did_you_mean(name, known)}")
    missing = [name for name, (_, default) in known.items() if default is ... and name not in options]
    if missing:
        raise SystemExit(f"the option '{missing[0]}' is missing.")
    return options


def _declared(module: str, dataset: str) -> Experiment:
    importlib.import_module(module)
    declared = DECLARED.get((module, dataset))
    if not isinstance(declared, Experiment):
        made = [name for of, name in DECLARED if of == module]
        raise SystemExit(f"{module} makes no dataset '{dataset}'; {did_you_mean(dataset, made)}")
    return declared


def _check_labels(made: xr.Dataset, module: str) -> None:
    """Refuse a dataset that does not explain itself."""
    if "title" not in made.attrs:
        raise SystemExit(f"the dataset of {module} needs a title among its attributes.")
    for name, variable in made.variables.items():
        if "long_name" not in variable.attrs:
            raise SystemExit(f"the variable '{name}' of {module} needs the attribute 'long_name'.")


def main(arguments: list[str]) -> None:
    """Make the datasets of one job, one for each output, and write each whole, with its provenance.

    The outputs are checked first.

    Raises
    ------
    SystemExit
        If an argument is wrong, the experiment fails, or a dataset cannot be written; the message is one sentence.
    """
    try:
        _make(arguments)
    except NotWritten as error:
        raise SystemExit(str(error)) from None


def _make(arguments: list[str]) -> None:
    if len(arguments) < 4:
        raise SystemExit("usage: python -m study.pipeline.command MODULE DATASET OUTPUT... 'JSON OPTIONS'")
    module, dataset, *outputs, text = arguments
    declared = _declared(module, dataset)
    paths, options = [check_writable(path) for path in outputs], _options(declared, text)
    # what has been imported stays: looking for garbage in it takes a sixth of the time of a job that compiles much
    gc.freeze()
    try:
        with datasets.reading_only(declared.reads(options)):
            made = declared.function(**options)
    except (ArithmeticError, KeyError, ValueError, RuntimeError, FileNotFoundError) as error:
        raise SystemExit(f"{module}: {error}") from error
    results = (made,) if isinstance(made, xr.Dataset) else made
    if not isinstance(results, tuple) or not all(isinstance(one, xr.Dataset) for one in results):
        raise SystemExit(f"{module} must return a dataset or a tuple of datasets, not {type(made).__name__}.")
    for one in results:
        _check_labels(one, module)
    if len(results) != len(paths):
        raise SystemExit(f"{module} makes {len(results)} datasets, for which {len(paths)} outputs were given.")
    for one, path in zip(results, paths, strict=True):
        one.attrs = provenance(one.attrs.pop("title"), f"python -m {module}") | one.attrs
        write(one, path)


def progress(message: str) -> None:
    """Tell the person who waits, and the log, what is being done."""
    print(message, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
