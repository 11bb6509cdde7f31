"""Checks of single numbers, without JAX."""

from typing import Any

import numpy as np


def is_number(value: Any) -> bool:
    """Whether a value is a single real number; a boolean is not."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def is_whole(value: Any, least: int) -> bool:
    """Whether a value is a whole number of at least ``least``; a boolean is not."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= least)
