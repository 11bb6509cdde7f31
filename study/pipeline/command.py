"""How the pipeline calls a function that makes datasets: ``python -m MODULE OUTPUT... 'JSON OPTIONS'``."""

import gc
import inspect
import json
import sys
from collections.abc import Callable

import xarray as xr

from study.datasets import check_writable, provenance, write
from study.registry import did_you_mean


def _options(function: Callable, text: str) -> dict:
    """Options of ``function`` out of a JSON object, refused with a sentence when they do not fit."""
    try:
        options = json.loads(text)
    except json.JSONDecodeError as error:
        raise SystemExit(f"the options must be a JSON object: {error}.") from None
    if not isinstance(options, dict):
        raise SystemExit(f"the options must be a JSON object, not {text}.")
    known = inspect.signature(function).parameters
    for name in options:
        if name not in known:
            raise SystemExit(f"there is no option '{name}'; {did_you_mean(name, known)}")
    missing = [name for name, p in known.items() if p.default is p.empty and name not in options]
    if missing:
        raise SystemExit(f"the option '{missing[0]}' is missing.")
    return options


def main(function: Callable[..., xr.Dataset | tuple[xr.Dataset, ...]]) -> None:
    """Make the datasets of ``function``, one for each output, and write each whole, with its provenance.

    The outputs are checked first.
    """
    module = sys.modules[function.__module__].__spec__.name  # type: ignore[union-attr]
    if len(sys.argv) < 3:
        raise SystemExit(f"usage: python -m {module} OUTPUT... 'JSON OPTIONS'")
    paths, options = [check_writable(path) for path in sys.argv[1:-1]], _options(function, sys.argv[-1])
    # what has been imported stays: looking for garbage in it takes a sixth of the time of a job that compiles much
    gc.freeze()
    try:
        made = function(**options)
    except (KeyError, ValueError, FileNotFoundError) as error:
        raise SystemExit(f"{module}: {error}") from error
    datasets = (made,) if isinstance(made, xr.Dataset) else made
    if len(datasets) != len(paths):
        raise SystemExit(f"{module} makes {len(datasets)} datasets, for which {len(paths)} outputs were given.")
    for dataset, path in zip(datasets, paths, strict=True):
        dataset.attrs = provenance(dataset.attrs.pop("title"), f"python -m {module}") | dataset.attrs
        write(dataset, path)


def progress(message: str) -> None:
    """Tell the person who waits, and the log, what is being done."""
    print(message, flush=True)
