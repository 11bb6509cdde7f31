"""The command that runs an experiment.

``python -m pipeline.command [--scheme=FILE.py:NAME ...] MODULE DATASET OUTPUT... 'JSON OPTIONS'`` makes the datasets of
one job. Each ``--scheme`` is a user's own scheme that the options name.
"""

import argparse
import importlib
import json
from collections.abc import Sequence

import xarray as xr

from pipeline.configuration import register_own
from study import io
from study.declaration.experiment import DECLARED, Experiment, arguments_of
from study.io import NotWritten, check_writable, provenance, write
from study.registry import did_you_mean


def _options(experiment: Experiment, text: str) -> dict:
    """Options of an experiment, read from the JSON object ``text``; unknown and missing options are refused."""
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
        names = [name for of, name in DECLARED if of == module]
        raise SystemExit(f"{module} makes no dataset '{dataset}'; {did_you_mean(dataset, names)}")
    return declared


def _check_labels(dataset: xr.Dataset, module: str) -> None:
    """Refuse a dataset without title or a variable without ``long_name``."""
    if "title" not in dataset.attrs:
        raise SystemExit(f"the dataset of {module} needs a title among its attributes.")
    for name, variable in dataset.variables.items():
        if "long_name" not in variable.attrs:
            raise SystemExit(f"the variable '{name}' of {module} needs the attribute 'long_name'.")


def main(arguments: Sequence[str] | None = None) -> None:
    """Make the datasets of one job, one for each output, with their provenance.

    An output that cannot be written is refused before the experiment runs.

    Raises
    ------
    SystemExit
        If an argument is wrong, the experiment fails, or a dataset cannot be written; the message is one sentence.
    """
    parser = argparse.ArgumentParser("python -m pipeline.command", description="Make the datasets of one job.")
    parser.add_argument("--scheme", action="append", default=[], metavar="FILE.py:NAME", help="a scheme of your own")
    parser.add_argument("module")
    parser.add_argument("dataset")
    parser.add_argument("outputs", nargs="+", metavar="OUTPUT")
    parser.add_argument("options", metavar="'JSON OPTIONS'")
    options = parser.parse_args(arguments)
    try:
        for place in options.scheme:
            register_own(place)
        _make(_declared(options.module, options.dataset), options.outputs, options.options)
    except (NotWritten, ValueError) as error:
        raise SystemExit(str(error)) from None


def _make(declared: Experiment, outputs: list[str], text: str) -> None:
    module = declared.module
    paths, options = [check_writable(path) for path in outputs], _options(declared, text)
    try:
        with io.reading_only(declared.reads(options)):
            result = declared.function(**options)
    except (ArithmeticError, KeyError, ValueError, RuntimeError, FileNotFoundError) as error:
        raise SystemExit(f"{module}: {error}") from error
    results = (result,) if isinstance(result, xr.Dataset) else result
    if not isinstance(results, tuple) or not all(isinstance(part, xr.Dataset) for part in results):
        raise SystemExit(f"{module} must return a dataset or a tuple of datasets, not {type(result).__name__}.")
    for dataset in results:
        _check_labels(dataset, module)
    if len(results) != len(paths):
        raise SystemExit(f"{module} makes {len(results)} datasets, for which {len(paths)} outputs were given.")
    for dataset, path in zip(results, paths, strict=True):
        dataset.attrs = provenance(dataset.attrs.pop("title"), f"python -m {module}") | dataset.attrs
        write(dataset, path)


if __name__ == "__main__":
    main()
