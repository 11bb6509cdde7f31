"""Datasets of the study: their attributes and provenance, how they are written, and how they are opened by name."""

import os
import platform
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from study.registry import nearest
from study.writing import whole

#: Folder of the pipeline's products, relative to the folder in which it runs.
RESULTS = Path("results")

#: Value of the attribute ``source``, by which :func:`read` knows the datasets of this study.
SOURCE = "study: time integration schemes on non-linear dynamic equations"
PAPER = (
    "Y. M. Xie, An assessment of time integration schemes for non-linear dynamic equations, "
    "Journal of Sound and Vibration 192(1), 1996, 321-331, doi:10.1006/jsvi.1996.0190"
)

#: Packages whose versions a dataset records. Some are needed for references only, and may be absent.
_PACKAGES = ("numpy", "scipy", "jax", "jaxlib", "diffrax", "scikit-sundae", "heyoka", "xarray", "netCDF4")


def _installed(package: str) -> str | None:
    """Version of a package, None if it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


#: Name of this package among the installed ones.
_NAME = "time-integration-study"


def _version() -> str:
    """Version of this package: of the checkout if there is one, whose installation may be older, or as installed."""
    pyproject = Path(__file__).parent.parent / "pyproject.toml"
    project = tomllib.loads(pyproject.read_text()).get("project", {}) if pyproject.exists() else {}
    return project["version"] if project.get("name") == _NAME else version(_NAME)


#: Version of this package, as ``pyproject.toml`` states it.
VERSION = _version()


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(
            ["git", *arguments], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _made_at() -> str:
    """Date of the sources, never the time of the run, so that the same inputs give the same bytes."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        return datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC).isoformat()
    return _git("log", "-1", "--format=%cI") or "undated"


def provenance(title: str, made_by: str) -> dict[str, str]:
    """Global attributes of a dataset: its title, what made it, and the versions of the sources and packages."""
    commit = _git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*") or "unknown"
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": SOURCE,
        "references": PAPER,
        "history": f"{_made_at()} made by {made_by}",
        "version": VERSION,
        "commit": commit,
        "packages": ", ".join(f"{name} {found}" for name in _PACKAGES if (found := _installed(name))),
        "python": ".".join(map(str, sys.version_info[:2])),
    }


def processor() -> str:
    """Name of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def flags(long_name: str, meanings: Sequence[str], dtype: type[np.integer]) -> dict[str, Any]:
    """Attributes of a variable whose values are places in ``meanings``, as the CF conventions have them.

    Parameters
    ----------
    meanings
        One word each, without spaces.
    dtype
        Type of the values of the variable, which CF asks of ``flag_values`` too.
    """
    return {
        "long_name": long_name,
        "flag_values": np.arange(len(meanings), dtype=dtype),
        "flag_meanings": " ".join(meanings),
    }


def _encoding(dataset: xr.Dataset) -> dict:
    """Compression of large variables; no fill value on coordinates and integers, which have no missing values.

    Flags that are floating point, because datasets without them were merged, are stored as integers with a fill value.
    """
    encoding: dict = {}
    for name, variable in dataset.variables.items():
        flag_type = np.asarray(variable.attrs.get("flag_values", 0.0)).dtype
        if variable.dtype.kind == "f" and flag_type.kind == "i":
            encoding[name] = {"dtype": flag_type, "_FillValue": np.array(-1, flag_type)}
        elif variable.dtype.kind == "f" and name not in dataset.coords:
            encoding[name] = {"zlib": True, "complevel": 4} if variable.size > 1024 else {}
        elif variable.dtype.kind in "fiu":
            encoding[name] = {"_FillValue": None}
    return encoding


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset whole or not at all.

    Raises
    ------
    NotWritten
        If it cannot be written; the message says why.
    """
    with whole(path) as unfinished:
        dataset.to_netcdf(unfinished, engine="netcdf4", encoding=_encoding(dataset))


#: The datasets that may be opened by name; all of them outside of an experiment.
_READABLE: ContextVar[frozenset[str] | None] = ContextVar("readable", default=None)


@contextmanager
def reading_only(names: Iterable[str]) -> Iterator[None]:
    """Refuse to open any other dataset by name, so that an experiment reads what it declares."""
    token = _READABLE.set(frozenset(names))
    try:
        yield
    finally:
        _READABLE.reset(token)


def open(name: str, folder: str | Path = RESULTS) -> xr.Dataset:
    """Open a dataset of the study by name, for instance ``study.open("energy_error")``.

    Parameters
    ----------
    name
        Name of the file without its ending, relative to the folder: ``"reference/hardening"``.
    folder
        Folder of the results.

    Raises
    ------
    FileNotFoundError
        If there is no such dataset; the message gives the nearest name and the command that makes the dataset.
    TypeError
        If it is no name.
    ValueError
        If a path is given in place of a name, or if the file is damaged or was not written by this study.
    """
    if not isinstance(name, str):
        raise TypeError(f"study.open takes the name of a dataset, not {name!r}.")
    if Path(name).suffix == ".nc":
        raise ValueError(
            f"study.open takes the name of a dataset, not its file: {_call_for(Path(name), Path(folder))}."
        )
    declared = _READABLE.get()
    if declared is not None and name not in declared:
        raise ValueError(f"the dataset '{name}' is read without being declared; add it to the reads of the experiment.")
    path = Path(folder) / f"{name}.nc"
    if not path.exists():
        present = sorted(p.relative_to(folder).with_suffix("").as_posix() for p in Path(folder).rglob("*.nc"))
        near = nearest(name, present)
        question = f"did you mean {' or '.join(map(repr, near))}? If not, " if near else ""
        raise FileNotFoundError(
            f"there is no dataset '{path}'; {question}`snakemake {path}` makes those of the study, in the folder of "
            "its sources, and `folder` names results elsewhere."
        )
    return read(path)


def _call_for(file: Path, folder: Path) -> str:
    """The call of :func:`open` for a file, given the folder that the user named."""
    if file.parent == Path():
        file = folder / file
    elif not file.is_relative_to(folder):
        folder = file.parent
    name = file.relative_to(folder).with_suffix("").as_posix()
    return f"study.open({name!r})" if folder == RESULTS else f"study.open({name!r}, folder={str(folder)!r})"


def read(path: str | Path) -> xr.Dataset:
    """Read a dataset of the study from a file.

    Raises
    ------
    ValueError
        If the file is not there, is damaged or was not written by this study.
    """
    again = f"move it away, and `snakemake {path}` makes it again."
    if not Path(path).exists():
        raise ValueError(f"there is no dataset '{path}'; `snakemake {path}` makes those of the study.")
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise ValueError(f"'{path}' cannot be used, it is damaged or no netCDF file ({error}): {again}") from None
    if dataset.attrs.get("source") != SOURCE:
        raise ValueError(f"'{path}' cannot be used, it was not written by this study: {again}")
    return dataset
