"""Put datasets together: ``python -m study.gather OUTPUT DIMENSIONS INPUT...``.

Datasets of the same form are put along a dimension, or along several (``rows,columns``) when they are given row by row;
those that complement each other are merged, with ``none`` for it.
"""

import sys
from collections.abc import Iterable
from itertools import groupby

import xarray as xr

from study.datasets import check_writable, provenance, read, write


def _along(dimensions: list[str], parts: Iterable[xr.Dataset]) -> xr.Dataset:
    """The parts along the first dimension, after those of the same place on it along the others."""
    first, *others = dimensions
    if others:
        parts = [_along(others, group) for _, group in groupby(parts, lambda part: part[first].values.tolist())]
    # what does not lie along the dimension is the same in all parts
    return xr.concat(parts, first, combine_attrs="override", data_vars="minimal", coords="minimal")


def main(output: str, dimensions: str, inputs: list[str]) -> None:
    """Put the parts together in the order given; the title of the first stays."""
    path = check_writable(output)
    try:
        parts = [read(name) for name in inputs]
    except ValueError as error:
        raise SystemExit(f"study.gather: {error}") from None
    # without their encodings, or names would be cut to the length of the first part's
    parts = [part.drop_encoding() for part in parts]
    if dimensions == "none":
        dataset = xr.merge(parts, join="outer", combine_attrs="override")
    else:
        dataset = _along(dimensions.split(","), parts)
    dataset.attrs = provenance(parts[0].title, "python -m study.gather")
    write(dataset, path)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        raise SystemExit("usage: python -m study.gather OUTPUT DIMENSIONS INPUT...")
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
