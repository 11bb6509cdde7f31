"""Combine datasets: ``python -m pipeline.gather OUTPUT DIMENSIONS INPUT...``.

DIMENSIONS is a dimension, several dimensions separated by commas, or ``none``. Datasets of the same variables are
concatenated along the dimensions. With two dimensions, ``rows,columns``, the inputs must be given row by row. With
``none``, datasets of different variables are merged.
"""

import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

import xarray as xr

from study.io import NotWritten, check_writable, provenance, read, write


def _along(dimensions: list[str], parts: Iterable[xr.Dataset]) -> xr.Dataset:
    """Concatenate datasets along all dimensions.

    Successive datasets with equal coordinates along the first dimension are joined along the other dimensions. The
    results are then joined along the first dimension.
    """
    first, *others = dimensions
    if others:
        parts = [_along(others, group) for _, group in groupby(parts, lambda part: part[first].values.tolist())]
    # variables without this dimension are the same in all parts
    return xr.concat(parts, first, combine_attrs="override", data_vars="minimal", coords="minimal")


def main(output: str, dimensions: str, inputs: list[str]) -> None:
    """Combine datasets in the given order, under the title of the first dataset.

    Raises
    ------
    SystemExit
        If a dataset is missing, damaged or not of this study, or the combined dataset cannot be written.
    """
    try:
        _gather(check_writable(output), dimensions, inputs)
    except (ValueError, NotWritten) as error:
        raise SystemExit(f"pipeline.gather: {error}") from None


def _gather(path: Path, dimensions: str, inputs: list[str]) -> None:
    parts = [read(name) for name in inputs]
    # the encoding of the first part would truncate longer names of other parts
    parts = [part.drop_encoding() for part in parts]
    if dimensions == "none":
        dataset = xr.merge(parts, join="outer", combine_attrs="override")
    else:
        dataset = _along(dimensions.split(","), parts)
    dataset.attrs = provenance(parts[0].title, "python -m pipeline.gather")
    write(dataset, path)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        raise SystemExit("usage: python -m pipeline.gather OUTPUT DIMENSIONS INPUT...")
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
