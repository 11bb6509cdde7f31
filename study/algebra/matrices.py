"""Square matrices, each stored in the smallest form that holds it, with their sums and products.

The forms in ascending order: a number (times the identity), a diagonal (n,), a :class:`Banded`, a
:class:`study.algebra.sparse.Sparse`, a full matrix (n, n) and a :class:`MatrixFree`, which is defined by its products.
All sparse matrices of a problem share one pattern.
"""

from collections.abc import Callable
from enum import IntEnum
from functools import reduce
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Full, Matrix, ScipySparse, Vector
from study.algebra.sparse import Sparse, SparseEntries

#: Largest number of unknowns for which products of full matrices are written out.
SMALL = 4


class Banded(NamedTuple):
    """A matrix of half bandwidth k: bands[k + d, i] is the entry (i, i + d), and zero outside the matrix.

    ``bands`` has the shape (2k + 1, n). The bands of a tridiagonal matrix should be a tuple of three vectors (n,),
    which the compiler need not write to memory before the solution.
    """

    bands: jax.Array | np.ndarray | tuple[jax.Array, ...]

    @property
    def half_bandwidth(self) -> int:
        """Largest distance of an entry from the diagonal."""
        return len(self.bands) // 2


class MatrixFree(NamedTuple):
    """A matrix given by a function for its product with a vector (n,), and by an approximate diagonal, () or (n,)."""

    product: Callable
    diagonal: jax.Array | float


class Form(IntEnum):
    """Forms of a matrix; each form can hold the matrices of the forms before it."""

    NUMBER, DIAGONAL, BAND, SPARSE, FULL, FREE = range(6)


def form_of(matrix: Matrix) -> Form:
    """The form in which a matrix is stored."""
    for kind, form in (
        (Banded, Form.BAND),
        (Sparse, Form.SPARSE),
        (SparseEntries, Form.SPARSE),
        (MatrixFree, Form.FREE),
    ):
        if isinstance(matrix, kind):
            return form
    return (Form.NUMBER, Form.DIAGONAL, Form.FULL)[jnp.ndim(matrix)]


def shifted(x: Vector, by: int) -> Vector:
    """The array of x[..., i + by], zero beyond the ends; unlike a concatenation, it needs no pass through memory."""
    return lax.pad(x, jnp.zeros((), x.dtype), [(0, 0, 0)] * (x.ndim - 1) + [(-by, by, 0)])


def _banded_times(matrix: Banded, x):
    k, n = matrix.half_bandwidth, len(x)
    if k <= 1:
        return sum(band * shifted(x, d) for d, band in enumerate(matrix.bands, start=-k))
    diagonals = jnp.pad(x, k)[jnp.arange(2 * k + 1)[:, None] + jnp.arange(n)[None]]
    return jnp.sum(jnp.stack(tuple(matrix.bands)) * diagonals, axis=0)


def _written_out(matrix, other):
    """Product of a small matrix (n, n) with a vector (n,) or a matrix (n, n), as a sum of outer products.

    XLA would compute a batched matrix product lane by lane.
    """
    return sum(jnp.multiply.outer(matrix[:, j], other[j]) for j in range(len(other)))


def times(matrix: Matrix, x: Vector) -> Vector:
    """Product of a matrix in any form with a vector (n,), or of two numbers."""
    match form_of(matrix):
        case Form.BAND:
            return _banded_times(matrix, x)
        case Form.SPARSE:
            return (matrix if isinstance(matrix, Sparse) else matrix.alone()).times(x)
        case Form.FULL:
            return _written_out(matrix, x) if len(x) <= SMALL else matrix @ x
        case Form.FREE:
            return matrix.product(x)
        case _:
            return matrix * x


def _as_band(matrix, n: int) -> Banded:
    return matrix if isinstance(matrix, Banded) else Banded(jnp.broadcast_to(matrix, (1, n)))


def _widened(matrix, form: Form, n: int):
    """The same matrix in a wider form: a band, full or matrix-free."""
    if form_of(matrix) == form:
        return matrix
    if form == Form.BAND:
        return _as_band(matrix, n)
    if form == Form.FULL:
        return dense(matrix, n)
    return MatrixFree(lambda x: times(matrix, x), diagonal(matrix))


def diagonal(matrix: Matrix) -> jax.Array | float:
    """The diagonal of a matrix in any form, a number or (n,)."""
    match form_of(matrix):
        case Form.BAND:
            return matrix.bands[matrix.half_bandwidth]
        case Form.SPARSE:
            return matrix.values[matrix.pattern.diagonal]
        case Form.FULL:
            return jnp.diag(matrix)
        case Form.FREE:
            return matrix.diagonal
        case _:
            return matrix


def banded(matrix: np.ndarray, half_bandwidth: int) -> Banded | np.ndarray:
    """A matrix (n, n) as a band of at least the given half bandwidth; unchanged if this would exceed n/4."""
    n = len(matrix)
    width = max(half_bandwidth, int(np.abs(np.subtract(*np.nonzero(matrix))).max(initial=0)))
    if 4 * width > n:
        return matrix
    bands = [np.pad(np.diagonal(matrix, d), (max(-d, 0), max(d, 0))) for d in range(-width, width + 1)]
    return Banded(np.stack(bands))


def banded_sparse(matrix: ScipySparse, half_bandwidth: int) -> Banded:
    """A matrix of :mod:`scipy.sparse` as a band of this half bandwidth, outside which it must have no entries."""
    n, offsets = matrix.shape[0], range(-half_bandwidth, half_bandwidth + 1)
    return Banded(np.stack([np.pad(matrix.diagonal(d), (max(-d, 0), max(d, 0))) for d in offsets]).reshape(-1, n))


def dense(matrix: Matrix, n: int) -> Full:
    """The full matrix (n, n) of any form except the matrix-free one."""
    match form_of(matrix):
        case Form.BAND:
            offsets = enumerate(matrix.bands, start=-matrix.half_bandwidth)
            return sum(jnp.diag(band[max(-d, 0) : n - max(d, 0)], d) for d, band in offsets if abs(d) < n)  # type: ignore[return-value]
        case Form.SPARSE:
            return matrix.dense()
        case Form.FULL:
            return matrix
        case _:
            return jnp.diag(jnp.broadcast_to(matrix, n))


def _sum_of_bands(first: Banded, second: Banded) -> Banded:
    wide, narrow = sorted((first, second), key=lambda m: m.half_bandwidth, reverse=True)
    gap = wide.half_bandwidth - narrow.half_bandwidth
    end = gap + len(narrow.bands)
    if isinstance(wide.bands, tuple):
        sums = (a + b for a, b in zip(wide.bands[gap:end], narrow.bands, strict=True))
        return Banded((*wide.bands[:gap], *sums, *wide.bands[end:]))
    inner = wide.bands[gap:end] + jnp.stack(tuple(narrow.bands))
    return Banded(jnp.concatenate([wide.bands[:gap], inner, wide.bands[end:]]))


def _sum_of_sparse(terms):
    matrices = [t for t in terms if isinstance(t, Sparse)]
    parts = [t for t in terms if isinstance(t, SparseEntries)]
    first, *rest = matrices or [parts.pop().alone()]
    total = Sparse(sum((t.values for t in rest), start=first.values), first.pattern)
    for entries in parts:
        total = entries.added_to(total)
    for diagonal in terms:
        if form_of(diagonal) != Form.SPARSE:
            total = total.plus(diagonal, total.pattern.diagonal)
    return total


def add(*terms: Matrix, n: int) -> Matrix:
    """Sum of matrices in any form, for n unknowns; a band must not be added to a sparse matrix."""
    form = max(map(form_of, terms))
    if form == Form.SPARSE:
        return _sum_of_sparse(terms)
    if form > Form.DIAGONAL:
        terms = tuple(_widened(t, form, n) for t in terms)
    if form == Form.BAND:
        return reduce(_sum_of_bands, terms)
    if form == Form.FREE:
        return MatrixFree(lambda x: sum(t.product(x) for t in terms), sum(t.diagonal for t in terms))
    return sum(terms[1:], start=terms[0])


def product(first: Matrix, second: Matrix, n: int) -> Matrix:
    """Product of two matrices, for n unknowns; if one is sparse, the other must be a number, full or matrix-free."""
    forms = form_of(first), form_of(second)
    if max(forms) < Form.BAND:
        return first * second
    if Form.NUMBER in forms:
        number, matrix = (first, second) if forms[0] == Form.NUMBER else (second, first)
        if isinstance(matrix, MatrixFree):
            return MatrixFree(lambda x: number * matrix.product(x), number * matrix.diagonal)
        return jax.tree.map(lambda part: number * part, matrix)
    if Form.FREE in forms:
        return MatrixFree(lambda x: times(first, times(second, x)), diagonal(first) * diagonal(second))
    if Form.FULL in forms:
        return _written_out(dense(first, n), dense(second, n)) if n <= SMALL else dense(first, n) @ dense(second, n)
    first, second = _as_band(first, n), _as_band(second, n)
    k = first.half_bandwidth
    bands = jnp.zeros((2 * (k + second.half_bandwidth) + 1, n))
    for d, left in enumerate(first.bands, start=-k):
        bands = bands.at[k + d : k + d + len(second.bands)].add(left[None] * shifted(jnp.stack(tuple(second.bands)), d))
    return Banded(bands)
