"""How the paper reads its datasets."""

from pathlib import Path

import xarray as xr


def load(path: str | Path) -> xr.Dataset:
    """Read a dataset whole; one that is damaged ends the program with a sentence."""
    try:
        return xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError) as error:
        raise SystemExit(
            f"'{path}' is damaged or no netCDF file ({error}); delete it and run `snakemake {path}`."
        ) from None
