"""Put datasets of the same form together along a dimension: ``python -m study.gather OUTPUT DIMENSION INPUT...``."""

import sys

import xarray as xr

from study.datasets import check_writable, provenance, write


def main(output: str, dimension: str, inputs: list[str]) -> None:
    """Concatenate the parts in the order given; their title stays."""
    path = check_writable(output)
    # without their encodings, or names would be cut to the length of the first part's
    parts = [xr.load_dataset(name).drop_encoding() for name in inputs]
    dataset = xr.concat(parts, dimension, combine_attrs="override")
    dataset.attrs = provenance(parts[0].title, "python -m study.gather")
    write(dataset, path)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
