"""Sparse matrices whose pattern is known when a problem is made, with their sums and products."""

import sys
from collections.abc import Iterable
from functools import partial
from hashlib import blake2b
from threading import Lock
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import scipy

from study.algebra.arrays import ScipySparse, Vector
from study.algebra.host import on_host

#: Largest difference of a symmetric matrix from its transpose, relative to the largest entry.
SYMMETRY = 1e-12


class Pattern:
    """The positions of the entries of a sparse matrix (n, n), column by column.

    Every pattern contains the diagonal. A symmetric pattern holds only the lower triangle. Any other pattern that
    contains (i, j) also contains (j, i). Patterns are equal if size, symmetry and positions are equal.

    Attributes
    ----------
    rows, columns
        Row and column of each entry, (entries,).
    diagonal
        Index of each diagonal entry among the entries, (n,).
    """

    def __init__(self, places: ScipySparse, symmetric: bool):
        n = places.shape[0]
        entries = scipy.sparse.csc_array(abs(places) + scipy.sparse.eye_array(n))
        entries = entries + entries.T
        entries = scipy.sparse.csc_array(scipy.sparse.tril(entries) if symmetric else entries)
        entries.sort_indices()
        self.size, self.symmetric = n, symmetric
        self.rows = entries.indices.astype(np.int32)
        self.columns = np.repeat(np.arange(n, dtype=np.int32), np.diff(entries.indptr))
        self.starts = entries.indptr
        self.diagonal = np.flatnonzero(self.rows == self.columns).astype(np.int32)
        self._matrix = scipy.sparse.csc_array((np.zeros(len(self.rows)), self.rows, self.starts), (n, n))
        self._mirrored, self._alone = self._matrix.T, Lock()
        self._key = n, symmetric, blake2b(self.rows.tobytes() + self.columns.tobytes()).digest()

    def __eq__(self, other):
        return isinstance(other, Pattern) and self._key == other._key

    def __hash__(self):
        return hash(self._key)

    def __repr__(self):
        return f"Pattern({self.size} unknowns, {len(self.rows)} entries{' of one triangle' * self.symmetric})"

    def numbers(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Index of each position in the list of entries of the pattern, which must contain all these positions."""
        order = self.columns.astype(np.int64) * self.size + self.rows
        return np.searchsorted(order, np.asarray(columns, np.int64) * self.size + rows).astype(np.int32)

    def values(self, matrix: ScipySparse) -> np.ndarray:
        """The values (entries,) of a matrix at the positions of the pattern."""
        places = scipy.sparse.coo_array(scipy.sparse.tril(matrix) if self.symmetric else matrix)
        values = np.zeros(len(self.rows))
        np.add.at(values, self.numbers(*places.coords), places.data)
        return values

    def product(self, values: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Product of the matrix with these values and a vector (n,)."""
        with self._alone:  # all threads share both matrices: to make new ones takes longer than the product
            self._matrix.data = self._mirrored.data = values
            product = self._matrix @ x
            return product + self._mirrored @ x - values[self.diagonal] * x if self.symmetric else product


class Sparse(eqx.Module):
    """A sparse matrix (n, n): the values (entries,) at the positions of its pattern."""

    values: jax.Array
    pattern: Pattern = eqx.field(static=True)

    def times(self, x: Vector) -> Vector:
        """Product with a vector (n,)."""
        return _times(self.pattern, self.values, x)

    def scattered_times(self, x: Vector) -> Vector:
        """The same product as a sum that JAX can differentiate and transpose."""
        pattern, values = self.pattern, self.values
        product = jnp.zeros_like(x).at[pattern.rows].add(values * x[pattern.columns])
        if not pattern.symmetric:
            return product
        off_diagonal = jnp.where(pattern.rows != pattern.columns, values, 0.0)
        return product.at[pattern.columns].add(off_diagonal * x[pattern.rows])

    def transposed(self) -> "Sparse":
        """The transposed matrix."""
        pattern = self.pattern
        if pattern.symmetric:
            return self
        return Sparse(self.values[pattern.numbers(pattern.columns, pattern.rows)], pattern)

    def plus(self, values: Vector, entries: np.ndarray) -> "Sparse":
        """The matrix plus ``values`` at the entries with the indices ``entries``."""
        return Sparse(jnp.asarray(self.values).at[entries].add(values), self.pattern)

    def within(self, pattern: Pattern) -> "Sparse":
        """The same matrix in a wider pattern; in a symmetric pattern, only the lower triangle of the matrix is kept."""
        rows, columns, values = self.pattern.rows, self.pattern.columns, jnp.asarray(self.values)
        if pattern.symmetric:
            lower = np.flatnonzero(rows >= columns)
            rows, columns, values = rows[lower], columns[lower], values[lower]
        wide = jnp.zeros(len(pattern.rows), values.dtype)
        return Sparse(wide.at[pattern.numbers(rows, columns)].add(values), pattern)

    def band(self, offset: int) -> jax.Array:
        """The entries (i, i + offset), as a vector (n,) with zeros where the pattern has no such entry."""
        rows, columns = self.pattern.rows, self.pattern.columns
        entries = np.flatnonzero(columns - rows == offset)
        values = jnp.asarray(self.values)
        return jnp.zeros(self.pattern.size, values.dtype).at[rows[entries]].set(values[entries])

    def dense(self) -> jax.Array:
        """The full matrix (n, n)."""
        pattern = self.pattern
        full = jnp.zeros((pattern.size,) * 2).at[pattern.rows, pattern.columns].set(self.values)
        return full.at[pattern.columns, pattern.rows].set(self.values) if pattern.symmetric else full


class SparseEntries(eqx.Module):
    """A sparse matrix (n, n) with few entries: their values, and ``form``.

    ``form`` holds the pattern, and the indices of these entries among the entries of the pattern.
    """

    values: jax.Array
    form: Any = eqx.field(static=True)

    def added_to(self, matrix: Sparse) -> Sparse:
        """The sum of both matrices; ``matrix`` has the same pattern."""
        return matrix.plus(self.values, self.form.entries)

    def alone(self) -> Sparse:
        """The same matrix as a :class:`Sparse`, with all entries of the pattern."""
        pattern = self.form.pattern
        return self.added_to(Sparse(jnp.zeros(len(pattern.rows), self.values.dtype), pattern))


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def _times(pattern: Pattern, values: jax.Array, x: Vector) -> Vector:
    """Product with a vector by SciPy, in a fifth of the time of a compiled program with scattered sums."""
    return on_host(pattern.product, x, values, x)


@_times.defjvp
def _derivative_of_times(pattern, primals, tangents):
    (values, x), (d_values, dx) = primals, tangents
    change = Sparse(d_values, pattern).scattered_times(x) + Sparse(values, pattern).scattered_times(dx)
    return _times(pattern, values, x), change


def is_sparse(matrix: Any) -> bool:
    """Whether ``matrix`` is a matrix of :mod:`scipy.sparse`."""
    # scipy.sparse takes a tenth of a second to import, and a caller with such a matrix has already imported it
    module = sys.modules.get("scipy.sparse")
    return module is not None and module.issparse(matrix)


def is_sparse_of_jax(matrix: Any) -> bool:
    """Whether ``matrix`` is a ``BCOO`` of :mod:`jax.experimental.sparse`, whose entries JAX may trace."""
    module = sys.modules.get("jax.experimental.sparse")
    return module is not None and isinstance(matrix, module.BCOO)


def from_jax(matrix: Any) -> ScipySparse | Sparse:
    """A ``BCOO`` as a matrix of :mod:`scipy.sparse`, or as a :class:`Sparse` if JAX traces its entries."""
    rows, columns = np.asarray(matrix.indices).T
    if not isinstance(matrix.data, jax.core.Tracer):
        return as_sparse(scipy.sparse.coo_array((np.asarray(matrix.data), (rows, columns)), matrix.shape))
    places = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), matrix.shape)
    pattern = Pattern(places, symmetric=False)
    values = jnp.zeros(len(pattern.rows), matrix.data.dtype).at[pattern.numbers(rows, columns)].add(matrix.data)
    return Sparse(values, pattern)


def as_sparse(matrix: Any) -> ScipySparse:
    """A matrix of :mod:`scipy.sparse`, in any format, as a ``csc_array`` of float64 without duplicate entries."""
    columns = scipy.sparse.csc_array(matrix).astype(np.float64)
    columns.sum_duplicates()
    return columns


def union(matrices: Iterable[ScipySparse]) -> ScipySparse:
    """A matrix with a positive entry wherever at least one of the matrices has an entry."""
    first, *rest = (
        scipy.sparse.csc_array((np.ones(m.nnz), m.indices, m.indptr), m.shape) for m in map(as_sparse, matrices)
    )
    return sum(rest, start=first)
