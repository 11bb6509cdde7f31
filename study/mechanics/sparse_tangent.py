"""The form of a sparse tangent: its pattern, and the products with the derivative of the force that give its entries.

Columns of one colour have no row in common and share a product (Curtis, Powell and Reid, 1974). A force that
acts on few unknowns, next to a constant stiffness, needs few products.

References
----------
A. R. Curtis, M. J. D. Powell, J. K. Reid, On the estimation of sparse Jacobian matrices, IMA J. Appl. Math. 13(1),
1974, 117-119.
"""

from collections.abc import Callable, Iterable
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import scipy

from study.algebra.arrays import Matrix, ScipySparse, Vector
from study.algebra.matrices import times
from study.algebra.sparse import Pattern, SparseEntries, union

#: Largest difference of a row of products that is round-off, over the sum of its terms.
ROUND_OFF = 1e-12
#: Maximum size of the part of the derivative that one call computes, in unknowns × columns. A part has at least one
#: column.
ROOM = 2**22


class SparseTangent:
    """Form of ∂p/∂u as :class:`SparseEntries`. Forms are equal if pattern, entries and colours are equal.

    Parameters
    ----------
    coupling
        Matrix (n, n) with an entry wherever the derivative of the force has one.
    others
        Matrices to which the tangent is added.
    symmetric
        Whether the tangent and the matrices ``others`` are symmetric.

    Attributes
    ----------
    pattern
        Positions of the entries of the tangent and of the other matrices.
    entries
        Indices, within the pattern, of the entries of the tangent.
    colours
        Number of colours; each needs one product with the derivative.
    """

    def __init__(self, coupling: ScipySparse, others: Iterable[ScipySparse], symmetric: bool):
        self.pattern = Pattern(union([coupling, *others]), symmetric)
        self._colour = coloured(coupling)
        self.colours = int(self._colour.max(initial=-1)) + 1
        places = scipy.sparse.coo_array(scipy.sparse.tril(coupling) if symmetric else coupling)
        self._rows, columns = (place.astype(np.int32) for place in places.coords)
        self._colour_of_entry = self._colour[columns]
        self.entries = self.pattern.numbers(self._rows, columns)
        self._key = self.pattern, self.entries.tobytes(), self._colour.tobytes()

    def __eq__(self, other):
        return isinstance(other, SparseTangent) and self._key == other._key

    def __hash__(self):
        return hash(self._key)

    def __repr__(self):
        return f"SparseTangent({self.pattern}, {len(self.entries)} entries of the force in {self.colours} products)"

    def force_and_tangent(self, force: Callable, u: Vector) -> tuple[Vector, Matrix]:
        """p(u) and ∂p/∂u; the tangent of a constant force is the number 0."""
        if not self.colours:
            return force(u), 0.0
        value, slope = jax.linearize(force, u)
        directions = self._colour[None] == np.arange(self.colours, dtype=np.int32)[:, None]
        products = jax.vmap(slope)(jnp.asarray(directions, u.dtype))
        return value, SparseEntries(products[self._colour_of_entry, self._rows], self)


def coloured(coupling: ScipySparse) -> np.ndarray:
    """A colour for each column (n,), so that columns of one colour share no row; −1 for an empty column."""
    rows = scipy.sparse.csc_array(coupling)
    shared = scipy.sparse.csr_array(rows.T @ rows)
    colour = np.full(rows.shape[1], -1, np.int32)
    for column in np.flatnonzero(np.diff(rows.indptr)):
        neighbours = colour[shared.indices[shared.indptr[column] : shared.indptr[column + 1]]]
        taken = np.zeros(len(neighbours) + 1, bool)
        taken[neighbours[(neighbours >= 0) & (neighbours < len(taken))]] = True
        colour[column] = np.argmin(taken)
    return colour


def coupling_of(force: Callable, states: Iterable[np.ndarray]) -> ScipySparse:
    """A matrix (n, n) with an entry wherever ∂p/∂u is not zero at one or more of the displacements (n,).

    The derivative is computed column by column only where a single product shows that the entries so far do not hold
    it: by a row that differs from that of the entries by more than the part ``ROUND_OFF`` of its terms.
    """

    @jax.jit
    def columns_with_entries(u, direction):
        return jax.vjp(force, u)[1](direction)[0]

    @jax.jit
    def derivatives(u, directions):
        _, slope = jax.linearize(force, u)
        return jax.vmap(slope)(directions)

    @partial(jax.jit, static_argnums=2)
    def misfit(u, direction, form):
        along = jax.jvp(force, (u,), (direction,))[1]
        if not form.colours:
            return jnp.abs(along), 0.0
        _, tangent = form.force_and_tangent(force, u)
        terms = SparseEntries(jnp.abs(tangent.values), form)
        return jnp.abs(along - times(tangent, direction)), times(terms, direction)

    coupling = None
    for u in states:
        n = len(u)
        coupling = scipy.sparse.csc_array((n, n)) if coupling is None else coupling
        scattered = np.random.default_rng(2).uniform(0.5, 1.5, n)
        outside, terms = misfit(u, scattered, SparseTangent(coupling, (), symmetric=False))
        if np.all(outside <= ROUND_OFF * np.asarray(terms)):
            continue
        at_once = max(1, min(n, ROOM // n))
        columns, patterns = np.flatnonzero(columns_with_entries(u, scattered)), [coupling]
        for first in range(0, len(columns), at_once):
            chunk = columns[first : first + at_once]
            directions = np.zeros((at_once, n))
            directions[np.arange(len(chunk)), chunk] = 1.0
            numbers, rows = np.nonzero(np.asarray(derivatives(u, directions))[: len(chunk)])
            patterns.append(scipy.sparse.csc_array((np.ones(len(rows)), (rows, chunk[numbers])), (n, n)))
        coupling = union(patterns)
    return coupling
