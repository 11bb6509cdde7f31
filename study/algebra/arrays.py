"""Array shapes for annotations, which are not checked at run time, and conversions of numbers to arrays.

n is the number of unknowns. A vector of a problem with one unknown is a number: its shape is ().
"""

import reprlib
from typing import Any, TypeAlias

import jax
import numpy as np
from jaxtyping import Array, Float

from study.algebra.scalars import check_unmasked

#: A number, shape ().
Scalar = Float[Array, ""]

#: A Python number or a JAX scalar.
ScalarLike = float | Scalar

#: A number for each unknown, shape () or (n,).
Vector = Float[Array, "*n"]

#: Values that can be converted to a ``Vector``: a number, a list or an array.
VectorLike = Float[Any, "*n"]

#: Values that can be converted to the positions of points, shape (points, directions).
PositionsLike = Float[Any, "points directions"]

#: A full matrix, shape (n, n).
Full = Float[Array, "n n"]

#: One or several right sides of a linear system, shape (n,) or (n, m).
RightSides = Float[Array, "n *m"]

#: A matrix in any form of :mod:`study.algebra.matrices`: a number, a diagonal (n,), ``Banded``, ``Sparse``, full or
#: ``MatrixFree``.
Matrix: TypeAlias = Any

#: A matrix of :mod:`scipy.sparse`, in any of its formats.
ScipySparse: TypeAlias = Any


def as_float64(value: Any) -> Any:
    """A number or an array, copied as float64; a value that JAX traces is returned unchanged."""
    if isinstance(value, jax.core.Tracer):
        return value
    check_unmasked("an array", value)
    return np.array(value, np.float64)[()]


def real_numbers(name: str, value: Any) -> np.ndarray:
    """Convert a real number, or a list or array of real numbers, to an array of float64.

    Raises
    ------
    ValueError
        If the value is anything else, a list whose rows differ in length, or an array with masked entries.
    """
    check_unmasked(name, value)
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "fiu":
        raise ValueError(f"{name} must be a real number or an array of real numbers, not {reprlib.repr(value)}.")
    return numbers.astype(np.float64)
