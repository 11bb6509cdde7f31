"""Checks of numbers, without JAX."""

from typing import Any

import numpy as np


def is_number(value: Any) -> bool:
    """Whether a value is a single real number; a boolean is not."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def is_whole(value: Any, least: int) -> bool:
    """Whether a value is a whole number of at least ``least``; a boolean is not."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= least)


def check_unmasked(name: str, value: Any) -> None:
    """Refuse an array with masked entries, or a masked number: NumPy would use values without a meaning."""
    rows = value if isinstance(value, list | tuple) else [value]
    if any(isinstance(row, np.ma.MaskedArray) for row in rows) and np.ma.is_masked(masked := np.ma.asarray(value)):
        place = ", ".join(str(axis[0]) for axis in np.nonzero(np.atleast_1d(np.ma.getmaskarray(masked))))
        raise ValueError(f"{name} has masked entries, the first at [{place}]: fill them, or leave them out.")
