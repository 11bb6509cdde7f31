"""Put datasets together: ``python -m study.gather OUTPUT DIMENSION INPUT...``.

Datasets of the same form are put along a dimension; those that complement each other are merged, with ``none`` for it.
"""

import sys

import xarray as xr

from study.datasets import check_writable, provenance, write


def main(output: str, dimension: str, inputs: list[str]) -> None:
    """Put the parts together in the order given; the title of the first stays."""
    path = check_writable(output)
    # without their encodings, or names would be cut to the length of the first part's
    parts = [xr.load_dataset(name).drop_encoding() for name in inputs]
    if dimension == "none":
        dataset = xr.merge(parts, join="outer", combine_attrs="override")
    else:
        # what does not lie along the dimension is the same in all parts
        dataset = xr.concat(parts, dimension, combine_attrs="override", data_vars="minimal", coords="minimal")
    dataset.attrs = provenance(parts[0].title, "python -m study.gather")
    write(dataset, path)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
