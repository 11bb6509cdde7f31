"""Files of the study: reading and atomic writing of datasets, tables and pages."""

import json
import os
import platform
import secrets
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from study.registry import nearest

#: Folder of the pipeline's products, relative to the folder in which it runs.
RESULTS = Path("results")

#: Value of the attribute ``source`` of every dataset of this study.
SOURCE = "study: time integration schemes on non-linear dynamic equations"
PAPER = (
    "Y. M. Xie, An assessment of time integration schemes for non-linear dynamic equations, "
    "Journal of Sound and Vibration 192(1), 1996, 321-331, doi:10.1006/jsvi.1996.0190"
)

#: Packages whose versions a dataset records. Some are needed for references only, and may be absent.
_PACKAGES = ("numpy", "scipy", "jax", "jaxlib", "diffrax", "scikit-sundae", "heyoka", "xarray", "netCDF4")

#: Name of this package among the installed ones.
_NAME = "time-integration-study"


def _version() -> str:
    """Version of the checkout, because an installation may be older; without a checkout, the installed version."""
    pyproject = Path(__file__).parent.parent / "pyproject.toml"
    project = tomllib.loads(pyproject.read_text()).get("project", {}) if pyproject.exists() else {}
    return project["version"] if project.get("name") == _NAME else version(_NAME)


#: Version of this package.
__version__ = _version()


def _installed() -> Iterator[str]:
    """Name and version of each package of ``_PACKAGES`` that is installed."""
    for package in _PACKAGES:
        try:
            yield f"{package} {version(package)}"
        except PackageNotFoundError:
            continue


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(
            ["git", *arguments], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _source_date() -> str:
    """``SOURCE_DATE_EPOCH`` as a date; empty if it is not set."""
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    return epoch and datetime.fromtimestamp(int(epoch), UTC).isoformat()


def now() -> str:
    """``SOURCE_DATE_EPOCH`` as a date, or otherwise the present date."""
    return _source_date() or datetime.now(UTC).isoformat(timespec="seconds")


def provenance(title: str, made_by: str, made_at: str | None = None) -> dict[str, str]:
    """Global attributes of a dataset: its title, its origin, and the versions of the sources and packages.

    The attributes have the names of the CF conventions and of the Attribute Convention for Data Discovery (ACDD).

    Parameters
    ----------
    title, made_by
        Title of the dataset, and the command or function that makes it.
    made_at
        Date. The default is ``SOURCE_DATE_EPOCH``, or the date of the last commit, or ``undated`` without both, so that
        the pipeline makes the same bytes from the same inputs.
    """
    made_at = made_at or _source_date() or _git("log", "-1", "--format=%cI") or "undated"
    return {
        "Conventions": "CF-1.11, ACDD-1.3",
        "title": title,
        "creator_name": "The founders of the study",
        "creator_type": "group",
        "license": "MIT",
        "date_created": made_at,
        "source": SOURCE,
        "references": PAPER,
        "history": f"{made_at} made by {made_by}",
        "version": __version__,
        "commit": _git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*") or "unknown",
        "packages": ", ".join(_installed()),
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
    """Attributes of a variable whose values are indices into ``meanings``, by the CF conventions.

    Parameters
    ----------
    meanings
        Meaning of each index, one word without spaces.
    dtype
        Type of the values of the variable. CF requires the same type for ``flag_values``.
    """
    return {
        "long_name": long_name,
        "flag_values": np.arange(len(meanings), dtype=dtype),
        "flag_meanings": " ".join(meanings),
    }


class NotWritten(OSError):
    """A file could not be written; the message names it and the reason."""


class NotRead(ValueError):
    """A file could not be read; the message names it, the reason, and the command that makes it again."""


@contextmanager
def one_sentence() -> Iterator[None]:
    """End a command with one sentence, without a traceback, if a file cannot be read or written."""
    try:
        yield
    except (NotRead, NotWritten) as error:
        raise SystemExit(str(error)) from None


def check_writable(path: str | Path) -> Path:
    """Make the folder of a file and check that the file can be written; the path is returned.

    Raises
    ------
    NotWritten
        If the file cannot be written; the message states why.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.parent):
            pass
        if path.is_dir():
            raise IsADirectoryError(None, "it is a folder")
    except OSError as error:
        raise NotWritten(f"'{path}' cannot be written: {error.strerror}.") from None
    return path


def _encoding(dataset: xr.Dataset, compressed: bool) -> dict:
    """Options by which netCDF stores each variable.

    If ``compressed``, variables of more than 1024 floating-point values are. Coordinates and integers get no fill
    value, since they have no missing values. Flags become floating point when they are merged with a dataset that lacks
    them; they are stored as integers with the fill value −1.
    """
    encoding: dict = {}
    for name, variable in dataset.variables.items():
        flag_type = np.asarray(variable.attrs.get("flag_values", 0.0)).dtype
        if variable.dtype.kind == "f" and flag_type.kind == "i":
            encoding[name] = {"dtype": flag_type, "_FillValue": np.array(-1, flag_type)}
        elif variable.dtype.kind == "f" and name not in dataset.coords:
            encoding[name] = {"zlib": True, "complevel": 4} if compressed and variable.size > 1024 else {}
        elif variable.dtype.kind in "fiu":
            encoding[name] = {"_FillValue": None}
    return encoding


def write(content: xr.Dataset | str | bytes, path: str | Path, *, compressed: bool = True) -> None:
    """Write a file atomically.

    The content is written to a temporary file next to ``path``. The temporary file then replaces the file at ``path``.
    If several processes write the same file, the last one wins, and readers always get a complete file.

    Parameters
    ----------
    compressed
        Whether large variables of a dataset are compressed, which may take longer than the runs that it holds.

    Raises
    ------
    NotWritten
        If the disk is full, or the file cannot be written for another reason. An existing file stays unchanged.
    """
    path = check_writable(path)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(8)}.unfinished")
    try:
        if isinstance(content, xr.Dataset):
            content.to_netcdf(unfinished, engine="netcdf4", encoding=_encoding(content, compressed))
        else:
            unfinished.write_bytes(content.encode() if isinstance(content, str) else content)
        with unfinished.open("rb") as file:
            os.fsync(file.fileno())
        unfinished.replace(path)
    except (OSError, RuntimeError) as error:
        # for a full disk netCDF may raise an error that does not mention the disk
        reason, free = getattr(error, "strerror", None) or error, shutil.disk_usage(path.parent).free
        raise NotWritten(f"'{path}' cannot be written: {reason}, {free:,} bytes are free.") from error
    finally:
        unfinished.unlink(missing_ok=True)


def _read_pdf(path: Path) -> bytes:
    content = path.read_bytes()
    if not (content.startswith(b"%PDF") and content.rstrip().endswith(b"%%EOF")):
        raise ValueError("it lacks %PDF at the beginning or %%EOF at the end")
    return content


_READERS = {
    ".nc": lambda path: xr.load_dataset(path, engine="netcdf4"),
    ".csv": lambda path: pd.read_csv(path, dtype=str, keep_default_na=False),
    ".json": lambda path: json.loads(path.read_bytes()),
    ".pdf": _read_pdf,
}


def read(path: str | Path) -> Any:
    """Read a file of the study.

    Returns
    -------
    xarray.Dataset, pandas.DataFrame of strings, content of JSON, or bytes of a PDF
        For the suffixes ``.nc``, ``.csv``, ``.json`` and ``.pdf``.

    Raises
    ------
    NotRead
        If the file is missing, empty or damaged, or is a dataset that was not written by this study.
    """
    path = Path(path)
    again = f"move it away, and `snakemake {path}` makes it again."
    if not path.is_file():
        raise NotRead(f"there is no file '{path}'; `snakemake {path}` makes it if the study has it.")
    if path.stat().st_size == 0:
        raise NotRead(f"'{path}' cannot be used, because it is empty: {again}")
    try:
        content = _READERS[path.suffix](path)
    except (OSError, RuntimeError, ValueError) as error:
        damage = f"it is damaged or not a {path.suffix} file ({error})"
        raise NotRead(f"'{path}' cannot be used, because {damage}: {again}") from None
    if isinstance(content, xr.Dataset) and content.attrs.get("source") != SOURCE:
        raise NotRead(f"'{path}' cannot be used, because it was not written by this study: {again}")
    return content


def opened(path: str | Path) -> xr.Dataset:
    """A netCDF file as a dataset whose variables are read when they are used.

    Raises
    ------
    NotRead
        If the file is missing or damaged.
    """
    try:
        return xr.open_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise NotRead(f"'{path}' cannot be used, because it is missing or damaged ({error}): move it away.") from None


class _Joined(BackendArray):
    """Variables of several files, one after the other along their first axis, read when they are used."""

    def __init__(self, parts: Sequence[xr.Variable]):
        self._parts, self._ends = parts, np.cumsum([len(part) for part in parts])
        self.shape, self.dtype = (int(self._ends[-1]), *parts[0].shape[1:]), parts[0].dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple) -> np.ndarray:
        rows, *rest = key
        indices = np.arange(self.shape[0])[rows]
        part = np.searchsorted(self._ends, np.atleast_1d(indices), side="right")
        places = np.atleast_1d(indices) - np.concatenate([[0], self._ends])[part]
        parts = np.unique(part) if part.size else part[:0]
        arrays = [self._parts[k][(places[part == k], *rest)].values for k in parts]
        whole = np.concatenate(arrays or [self._parts[0][(places, *rest)].values])
        whole[np.argsort(part, kind="stable")] = whole.copy()  # rows may be wanted in any order
        return whole if np.ndim(indices) else whole[0]


def opened_together(datasets: Sequence[xr.Dataset], dim: str) -> xr.Dataset:
    """Opened files as one dataset, joined along the first dimension of their variables; only coordinates are read.

    ``xarray.concat`` would read all variables.
    """

    def joined(name: Any) -> xr.Variable:
        parts = [dataset.variables[name] for dataset in datasets]
        if parts[0].dims[:1] != (dim,):
            return parts[0]
        return xr.Variable(parts[0].dims, indexing.LazilyIndexedArray(_Joined(parts)), parts[0].attrs)

    first = datasets[0]
    data, coordinates = ({name: joined(name) for name in names} for names in (first.data_vars, first.coords))
    return xr.Dataset(data, coordinates, first.attrs)


#: Names of the datasets that :func:`open_dataset` may open; None, outside of an experiment, allows all datasets.
_READABLE: ContextVar[frozenset[str] | None] = ContextVar("readable", default=None)


@contextmanager
def reading_only(names: Iterable[str]) -> Iterator[None]:
    """Within this context only these datasets can be opened by name: an experiment reads only what it declares."""
    token = _READABLE.set(frozenset(names))
    try:
        yield
    finally:
        _READABLE.reset(token)


def open_dataset(name: str, folder: str | Path = RESULTS) -> xr.Dataset:
    """Open a dataset of the study by name, for instance ``study.open_dataset("energy_error")``.

    Parameters
    ----------
    name
        Name of the file without its suffix, relative to the folder: ``"reference/hardening"``.
    folder
        Folder of the results, by default ``results``.

    Raises
    ------
    FileNotFoundError
        If there is no such dataset; the message gives similar names and the command that makes the dataset.
    ValueError
        If a file is given in place of a name, if an experiment reads a dataset that it does not declare, or if the
        dataset is damaged or was not written by this study.
    """
    if str(name).endswith(".nc"):
        raise ValueError(
            "study.open_dataset takes a name such as 'accuracy' or 'reference/hardening', and another folder of "
            f"results as `folder`, not the file '{name}'."
        )
    declared = _READABLE.get()
    if declared is not None and name not in declared:
        raise ValueError(f"the dataset '{name}' is read without being declared; add it to the reads of the experiment.")
    path = Path(folder) / f"{name}.nc"
    if not path.exists():
        present = sorted(p.relative_to(folder).with_suffix("").as_posix() for p in Path(folder).rglob("*.nc"))
        near = nearest(str(name), present)
        meant = f"'{name}' may mean {' or '.join(map(repr, near))}, " if near else ""
        raise FileNotFoundError(
            f"there is no dataset '{path}': {meant}another folder of results is given as `folder`, and a dataset of "
            f"the study is made by `snakemake {path}` in the folder of its sources."
        )
    return read(path)
