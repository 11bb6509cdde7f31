"""How the paper reads its datasets."""

from pathlib import Path

import numpy as np
import xarray as xr

from paper.published import printed_energy_errors


def load(path: str | Path) -> xr.Dataset:
    """Read a dataset whole; one that is damaged ends the program with a sentence."""
    try:
        return xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise SystemExit(
            f"'{path}' is damaged or no netCDF file ({error}); delete it and run `snakemake {path}`."
        ) from None


def of_the_paper(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset that has the paper's own schemes, in the order of its tables."""
    return dataset.sel(scheme=printed_energy_errors().scheme.values)


def families(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    """The parts of a dataset that have the schemes of one family each, in the order in which families appear."""
    names = dict.fromkeys(dataset.family.values.tolist())
    return {name: dataset.isel(scheme=np.flatnonzero(dataset.family.values == name)) for name in names}
