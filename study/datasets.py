"""Datasets that explain themselves: attributes, provenance, safe writing, opening by name."""

import os
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from study.registry import did_you_mean

#: Where the pipeline leaves its products, in the folder in which it runs.
RESULTS = Path("results")
SOURCE = "study: time integration schemes on non-linear dynamic equations"
PAPER = (
    "Y. M. Xie, An assessment of time integration schemes for non-linear dynamic equations, "
    "Journal of Sound and Vibration 192(1), 1996, 321-331, doi:10.1006/jsvi.1996.0190"
)
_PACKAGES = ("numpy", "jax", "jaxlib", "diffrax", "scikit-sundae", "xarray", "netCDF4")


def _git(*arguments: str) -> str:
    try:
        done = subprocess.run(
            ["git", *arguments], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _made_at() -> str:
    """When the sources were made: never the wall clock, so that the same inputs give the same bytes."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        return datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC).isoformat()
    return _git("log", "-1", "--format=%cI") or "undated"


def provenance(title: str, made_by: str) -> dict[str, str]:
    """Global attributes of a dataset: what it is, what made it, from which sources and packages."""
    commit = _git("describe", "--always", "--dirty", "--abbrev=40", "--exclude=*") or "unknown"
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": SOURCE,
        "references": PAPER,
        "history": f"{_made_at()} made by {made_by}",
        "commit": commit,
        "packages": ", ".join(f"{name} {version(name)}" for name in _PACKAGES),
        "python": ".".join(map(str, sys.version_info[:2])),
    }


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
    """Compression for what is large; no fill value on coordinates and integers, which have no missing values."""
    encoding: dict = {}
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "f" and name not in dataset.coords:
            encoding[name] = {"zlib": True, "complevel": 4} if variable.size > 1024 else {}
        elif variable.dtype.kind in "fiu":
            encoding[name] = {"_FillValue": None}
    return encoding


def check_writable(path: str | Path) -> Path:
    """Make the folder of ``path`` and make sure that a file can be written there."""
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SystemExit(f"the results folder '{path.parent}' cannot be made: {error.strerror}.") from None
    if not os.access(path.parent, os.W_OK):
        raise SystemExit(f"the results folder '{path.parent}' is not writable; choose one that is.")
    if path.is_dir():
        raise SystemExit(f"'{path}' is a folder; the dataset needs the name.")
    return path


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset whole or not at all: to a neighbour first, which then takes the name."""
    path = check_writable(path)
    unfinished = path.with_name(f".{path.name}.unfinished")
    try:
        dataset.to_netcdf(unfinished, engine="netcdf4", encoding=_encoding(dataset))
        os.replace(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def open(name: str, folder: str | Path = RESULTS) -> xr.Dataset:
    """Open a dataset of the study by name, for instance ``study.open("energy_error")``.

    Raises
    ------
    FileNotFoundError
        If the file is not there; the message says what to run.
    ValueError
        If the file is damaged or was not written by this study.
    """
    path = Path(folder) / f"{name}.nc"
    if not path.exists():
        present = sorted(p.relative_to(folder).with_suffix("").as_posix() for p in Path(folder).rglob("*.nc"))
        hint = f" Among those that are there: {did_you_mean(str(name), present)}" if present else ""
        raise FileNotFoundError(f"there is no dataset '{path}'; `snakemake {path}` makes those of the study.{hint}")
    return read(path)


def read(path: str | Path) -> xr.Dataset:
    """Read a dataset of the study from a file.

    Raises
    ------
    ValueError
        If the file is not there, is damaged or was not written by this study.
    """
    again = f"delete it and run `snakemake {path}`."
    if not Path(path).exists():
        raise ValueError(f"there is no dataset '{path}'; `snakemake {path}` makes those of the study.")
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise ValueError(f"'{path}' is damaged or no netCDF file ({error}); {again}") from None
    if dataset.attrs.get("source") != SOURCE:
        raise ValueError(f"'{path}' was not written by this study; {again}")
    return dataset
