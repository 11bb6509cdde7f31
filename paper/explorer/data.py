"""Data of the page: maps of stability and largest safe steps, packed as text."""

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from paper.data import largest_safe

#: Largest number of amplitudes, and of step sizes, of a map on the page. A cell is then about ten pixels wide.
CELLS = 64
#: Selectable allowed errors.
ERRORS = (0.1, 0.01, 0.001)
#: Number of integer codes for each doubling of an error.
LOG_CODES = 512


def packed(blocks: Mapping[str, np.ndarray]) -> tuple[dict[str, Any], str]:
    """The place of each array (offset, type and shape, by name) in a block of bytes, and the block as one text.

    The text is base64 of the compressed bytes, which browsers can unpack without a library. Arrays of wider numbers
    come first, so that each array starts at a multiple of the width of its numbers.
    """
    order = sorted(blocks, key=lambda name: -blocks[name].itemsize)
    offsets = np.cumsum([0, *(blocks[name].nbytes for name in order)]).tolist()
    places = {
        name: {"offset": offset, "type": blocks[name].dtype.name, "shape": list(blocks[name].shape)}
        for name, offset in zip(order, offsets, strict=False)
    }
    content = b"".join(blocks[name].astype(blocks[name].dtype.newbyteorder("<")).tobytes() for name in order)
    return places, base64.b64encode(zlib.compress(content, 9)).decode()


def _logarithmic(values: np.ndarray) -> np.ndarray:
    """Base-2 logarithms times ``LOG_CODES`` as integers of two bytes, clipped to their range; -32768 stands for NaN."""
    with np.errstate(divide="ignore"):
        codes = np.clip(np.round(LOG_CODES * np.log2(values)), -32767, 32767)
    return np.where(np.isnan(codes), -32768, codes).astype(np.int16)


def coarse(dataset: xr.Dataset) -> xr.Dataset:
    """A map thinned to at most ``CELLS`` amplitudes and at most ``CELLS`` step sizes."""
    strides = {name: -(-dataset.sizes[name] // CELLS) for name in ("amplitude", "step_size_over_period")}
    return dataset.isel({name: slice(None, None, stride) for name, stride in strides.items()})


def map_arrays(atlas: xr.Dataset) -> dict[str, np.ndarray]:
    """Arrays of the page: outcomes and errors of the maps, and the largest safe steps.

    The arrays of the maps have the shape (problem, scheme, amplitude, step size). The largest safe Δt/T have the shape
    (error, problem, scheme, amplitude), and are zero where the finest step is not safe.
    """
    maps = coarse(atlas).transpose("problem", "scheme", "amplitude", "step_size_over_period", ...)
    safe = xr.concat([largest_safe(atlas.sel(amplitude=maps.amplitude), error) for error in ERRORS], "error")
    return {
        "outcome": maps.outcome.values.astype(np.uint8),
        "energy": _logarithmic(100 * maps.max_energy_error.values),
        "period": _logarithmic(100 * maps.period_error.values),
        "safe": safe.transpose("error", "problem", "scheme", "amplitude").values.astype(np.float32),
    }
