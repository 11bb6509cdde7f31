"""How the paper reads its datasets."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from paper.published import PROBLEMS, SCHEMES, STEPS

#: The attribute ``source`` of every dataset of the study.
SOURCE = "study: time integration schemes on non-linear dynamic equations"

#: Structures that turn, so that their stiff modes are not linear.
TURNING = ["elastic_pendulum", "spinning_truss"]


def unusable(path: Path, reason: str) -> SystemExit:
    """What ends the program because of a file; in the pipeline the words tell which one to make again."""
    return SystemExit(f"'{path}' cannot be used, it is {reason}: move it away, and `snakemake {path}` makes it again.")


def _check_there(path: Path) -> None:
    """End the program with a sentence if a file is missing or empty."""
    if not path.is_file():
        raise SystemExit(f"There is no file '{path}'; make it with `snakemake {path}`.")
    if path.stat().st_size == 0:
        raise unusable(path, "empty")


def load(path: str | Path) -> xr.Dataset:
    """Read a whole dataset.

    Raises
    ------
    SystemExit
        If the file is missing, empty, damaged or no dataset of the study; the message is one sentence.
    """
    _check_there(Path(path))
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise unusable(Path(path), f"damaged or no netCDF file ({error})") from None
    if dataset.attrs.get("source") != SOURCE:
        raise unusable(Path(path), "not of this study")
    return dataset


def load_table(path: str | Path) -> pd.DataFrame:
    """Read a CSV file as texts.

    Raises
    ------
    SystemExit
        If the file is missing, empty or damaged; the message is one sentence.
    """
    _check_there(Path(path))
    try:
        return pd.read_csv(path, dtype=str, keep_default_na=False)
    except ValueError as error:
        raise unusable(Path(path), f"damaged or no CSV file ({error})") from None


def check_included(path: Path) -> None:
    """End the program with a sentence if a file that the manuscript includes is missing, empty or not whole."""
    _check_there(path)
    content = path.read_bytes()
    if path.suffix == ".pdf" and not (content.startswith(b"%PDF") and content.rstrip().endswith(b"%%EOF")):
        raise unusable(path, "no whole PDF")
    if path.suffix == ".json":
        try:
            json.loads(content)
        except ValueError as error:
            raise unusable(path, f"damaged or no JSON file ({error})") from None


def of_the_paper(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset with the schemes of 1996, in the order of the paper's tables."""
    return dataset.sel(scheme=SCHEMES)


def of_the_tables(energy_errors: xr.Dataset) -> xr.Dataset:
    """The part of a dataset with the schemes, problems and step sizes of Tables 1 and 2, in their order."""
    return of_the_paper(energy_errors).sel(problem=PROBLEMS, steps_per_period=STEPS)


def families(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    """The parts of a dataset with the schemes of one family each, in the order in which the families appear."""
    names = dict.fromkeys(dataset.family.values.tolist())
    return {name: dataset.isel(scheme=np.flatnonzero(dataset.family.values == name)) for name in names}


def of_kinds(dataset: xr.Dataset, schemes: Sequence[str]) -> xr.Dataset:
    """The part of a dataset with those of some schemes that it has, or with as many of its own if it has none."""
    there = [name for name in schemes if name in dataset.scheme.values]
    return dataset.sel(scheme=there or dataset.scheme.values[: len(schemes)])


def loss_of_amplitude(errors: xr.Dataset, shorter: int, longer: int) -> xr.DataArray:
    """Size of the loss of amplitude per period of the longer runs, NaN where it is no loss.

    Schemes that keep the amplitude have a ripple, which depends on where steps fall and does not grow with the length
    of the run. A loss per period is the same, within a factor of two, in runs of both lengths at five neighbouring step
    sizes.
    """
    size = abs(errors.amplitude_decay)
    ratio = size.sel(periods=longer) / size.sel(periods=shorter)
    neighbours = min(5, ratio.sizes["steps_per_period"])
    steady = ((ratio > 0.5) & (ratio < 2)).rolling(steps_per_period=neighbours).sum() == neighbours
    ends = [steady.shift(steps_per_period=-ahead, fill_value=False) for ahead in range(neighbours)]
    return size.sel(periods=longer).where(np.logical_or.reduce(ends))
