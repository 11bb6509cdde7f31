"""Square matrices in the least form that holds them, and what the schemes do with them: products, sums, solutions.

In ascending order of what they hold: a number (times the identity), a diagonal (n,), a :class:`Banded`, a matrix (n, n)
and a :class:`MatrixFree`, of which only the products are known.
"""

from collections.abc import Callable
from enum import IntEnum
from functools import reduce
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

#: Systems of up to this many unknowns are eliminated without a loop: a call of LAPACK would take ten times longer.
SMALL = 4
#: Rows of a tridiagonal elimination in one turn of its loop.
UNROLL = 4
#: Relative residual at which an iteration of a matrix-free system ends, and its length at most.
ITERATIVE_TOLERANCE, ITERATIVE_STEPS = 1e-10, 10_000


class Banded(NamedTuple):
    """A matrix with entries within k of the diagonal: bands[k + d, i] is entry (i, i + d), zero where there is none.

    ``bands`` has the shape (2k + 1, n); three of them are better a tuple of (n,), which the compiler need not write to
    memory before it solves.
    """

    bands: jax.Array | np.ndarray | tuple[jax.Array, ...]

    @property
    def half_bandwidth(self) -> int:
        """Largest distance of an entry from the diagonal."""
        return len(self.bands) // 2


class MatrixFree(NamedTuple):
    """A matrix of which the product with a vector (n,) is known, and roughly the diagonal, a number or (n,)."""

    product: Callable
    diagonal: jax.Array | float


class Form(IntEnum):
    """What a matrix is held as, in ascending order of what the form can hold."""

    NUMBER, DIAGONAL, BAND, FULL, FREE = range(5)


def _form(matrix) -> Form:
    if isinstance(matrix, Banded | MatrixFree):
        return Form.BAND if isinstance(matrix, Banded) else Form.FREE
    return (Form.NUMBER, Form.DIAGONAL, Form.FULL)[jnp.ndim(matrix)]


def shifted(x, by: int):
    """x[..., i + by], zero beyond the ends; other than a concatenation it costs no pass through memory."""
    return lax.pad(x, jnp.zeros((), x.dtype), [(0, 0, 0)] * (x.ndim - 1) + [(-by, by, 0)])


def _banded_times(matrix: Banded, x):
    k, n = matrix.half_bandwidth, len(x)
    if k <= 1:
        return sum(band * shifted(x, d) for d, band in enumerate(matrix.bands, start=-k))
    beside = jnp.pad(x, k)[jnp.arange(2 * k + 1)[:, None] + jnp.arange(n)[None]]
    return jnp.sum(jnp.stack(tuple(matrix.bands)) * beside, axis=0)


def _written_out(matrix, other):
    """Product of a small matrix (n, n) with (n,) or (n, n): many lanes of a product as such are taken one by one."""
    return sum(jnp.multiply.outer(matrix[:, j], other[j]) for j in range(len(other)))


def times(matrix, x):
    """Product of a matrix of any form with a vector (n,), or of a number with a number."""
    match _form(matrix):
        case Form.BAND:
            return _banded_times(matrix, x)
        case Form.FULL:
            return _written_out(matrix, x) if len(x) <= SMALL else matrix @ x
        case Form.FREE:
            return matrix.product(x)
        case _:
            return matrix * x


def _as_band(matrix, n: int) -> Banded:
    return matrix if isinstance(matrix, Banded) else Banded(jnp.broadcast_to(matrix, (1, n)))


def _widened(matrix, form: Form, n: int):
    """The same matrix in a form above a diagonal."""
    if _form(matrix) == form:
        return matrix
    if form == Form.BAND:
        return _as_band(matrix, n)
    if form == Form.FULL:
        return dense(matrix, n)
    return MatrixFree(lambda x: times(matrix, x), _diagonal(matrix))


def _diagonal(matrix):
    match _form(matrix):
        case Form.BAND:
            return matrix.bands[matrix.half_bandwidth]
        case Form.FULL:
            return jnp.diag(matrix)
        case Form.FREE:
            return matrix.diagonal
        case _:
            return matrix


def banded(matrix: np.ndarray, half_bandwidth: int) -> "Banded | np.ndarray":
    """A matrix (n, n) as a band of this half width at least, or as it is where the band would be a quarter of it."""
    n = len(matrix)
    width = max(half_bandwidth, int(np.abs(np.subtract(*np.nonzero(matrix))).max(initial=0)))
    if 4 * width > n:
        return matrix
    bands = [np.pad(np.diagonal(matrix, d), (max(-d, 0), max(d, 0))) for d in range(-width, width + 1)]
    return Banded(np.stack(bands))


def dense(matrix, n: int):
    """The matrix (n, n) of any form but that without a matrix."""
    match _form(matrix):
        case Form.BAND:
            offsets = enumerate(matrix.bands, start=-matrix.half_bandwidth)
            return sum(jnp.diag(band[max(-d, 0) : n - max(d, 0)], d) for d, band in offsets if abs(d) < n)
        case Form.FULL:
            return matrix
        case _:
            return jnp.diag(jnp.broadcast_to(matrix, n))


def _sum_of_bands(one: Banded, other: Banded) -> Banded:
    wide, narrow = sorted((one, other), key=lambda m: m.half_bandwidth, reverse=True)
    gap = wide.half_bandwidth - narrow.half_bandwidth
    end = gap + len(narrow.bands)
    if isinstance(wide.bands, tuple):
        sums = (a + b for a, b in zip(wide.bands[gap:end], narrow.bands, strict=True))
        return Banded((*wide.bands[:gap], *sums, *wide.bands[end:]))
    inner = wide.bands[gap:end] + jnp.stack(tuple(narrow.bands))
    return Banded(jnp.concatenate([wide.bands[:gap], inner, wide.bands[end:]]))


def add(*terms, n: int):
    """Sum of matrices of any form, for n unknowns."""
    form = max(map(_form, terms))
    if form > Form.DIAGONAL:
        terms = tuple(_widened(t, form, n) for t in terms)
    if form == Form.BAND:
        return reduce(_sum_of_bands, terms)
    if form == Form.FREE:
        return MatrixFree(lambda x: sum(t.product(x) for t in terms), sum(t.diagonal for t in terms))
    return sum(terms[1:], start=terms[0])


def product(one, other, n: int):
    """Product of two matrices of any form, for n unknowns."""
    forms = _form(one), _form(other)
    if max(forms) < Form.BAND:
        return one * other
    if Form.NUMBER in forms:
        number, matrix = (one, other) if forms[0] == Form.NUMBER else (other, one)
        if isinstance(matrix, MatrixFree):
            return MatrixFree(lambda x: number * matrix.product(x), number * matrix.diagonal)
        return jax.tree.map(lambda part: number * part, matrix)
    if Form.FREE in forms:
        return MatrixFree(lambda x: times(one, times(other, x)), _diagonal(one) * _diagonal(other))
    if Form.FULL in forms:
        return _written_out(dense(one, n), dense(other, n)) if n <= SMALL else dense(one, n) @ dense(other, n)
    one, other = _as_band(one, n), _as_band(other, n)
    k = one.half_bandwidth
    bands = jnp.zeros((2 * (k + other.half_bandwidth) + 1, n))
    for d, left in enumerate(one.bands, start=-k):
        bands = bands.at[k + d : k + d + len(other.bands)].add(left[None] * shifted(jnp.stack(tuple(other.bands)), d))
    return Banded(bands)


def eliminate(matrix, rhs):
    """Gaussian elimination with partial pivoting, written out for a small matrix (n, n) and right sides (n, ...)."""
    n = len(rhs)
    rows = [[*(matrix[i, j] for j in range(n)), rhs[i]] for i in range(n)]
    for k in range(n):
        for i in range(k + 1, n):
            swap = jnp.abs(rows[i][k]) > jnp.abs(rows[k][k])
            pivot = [jnp.where(swap, lower, upper) for upper, lower in zip(rows[k], rows[i], strict=True)]
            rest = [jnp.where(swap, upper, lower) for upper, lower in zip(rows[k], rows[i], strict=True)]
            factor = rest[k] / pivot[k]
            rows[k], rows[i] = pivot, [low - factor * high for low, high in zip(rest, pivot, strict=True)]
    x: list = []
    for k in reversed(range(n)):
        known = sum(rows[k][n - 1 - i] * x[i] for i in range(len(x)))
        x.append((rows[k][n] - known) / rows[k][k])
    return jnp.stack(x[::-1])


def _solve_tridiagonal(bands, rhs):
    """Thomas' elimination in place, a few rows a turn, without pivoting, which M + c K does without."""
    lower, middle, upper = bands
    n = len(rhs)
    rest = n % UNROLL

    def down(start, size, carry):
        upper, right, above, solved = carry
        rows = (lax.dynamic_slice(x, (start,), (size,)) for x in (lower, middle, upper, right))
        now = []
        for low, diagonal, high, b in zip(*rows, strict=True):
            pivot = 1 / (diagonal - low * above)
            above, solved = high * pivot, (b - low * solved) * pivot
            now.append((above, solved))
        ratios, values = (jnp.stack(x) for x in zip(*now, strict=True))
        place = (start,)
        return (
            lax.dynamic_update_slice(upper, ratios, place),
            lax.dynamic_update_slice(right, values, place),
            above,
            solved,
        )

    def up(start, size, carry):
        right, x = carry
        rows = (lax.dynamic_slice(x, (start,), (size,)) for x in (upper, right))
        now = []
        for ratio, value in reversed(list(zip(*rows, strict=True))):
            x = value - ratio * x
            now.append(x)
        return lax.dynamic_update_slice(right, jnp.stack(now[::-1]), (start,)), x

    zero = jnp.zeros((), rhs.dtype)
    carry = upper, rhs, zero, zero
    if n < UNROLL:
        upper, right, _, _ = down(0, n, carry)
        return up(0, n, (right, zero))[0]
    carry = lax.fori_loop(0, n // UNROLL, lambda i, c: down(i * UNROLL, UNROLL, c), carry)
    upper, right, _, _ = down(n - rest, rest, carry) if rest else carry
    back = up(n - rest, rest, (right, zero)) if rest else (right, zero)
    return lax.fori_loop(0, n // UNROLL, lambda i, c: up(n - rest - (i + 1) * UNROLL, UNROLL, c), back)[0]


def _solve_banded(bands, rhs):
    """Thomas' elimination of k by k blocks, with pivoting within a block."""
    k, n = len(bands) // 2, len(rhs)
    blocks = -(-n // k)
    spare = blocks * k - n
    # rows of three blocks; those beyond the end are rows of the identity
    padded = jnp.pad(bands, ((0, 0), (0, spare))).at[k, n:].set(1.0).T.reshape(blocks, k, 2 * k + 1)
    row, place = np.arange(k)[:, None], np.arange(2 * k + 1)
    wide = jnp.zeros((blocks, k, 3 * k)).at[:, row, row + place].set(padded)
    low, middle, high = wide[:, :, :k], wide[:, :, k : 2 * k], wide[:, :, 2 * k :]

    def down(above, row):
        upper, right = above
        low, middle, high, b = row
        rhs = jnp.column_stack([high, b - low @ right])
        solved = eliminate(middle - low @ upper, rhs) if k <= SMALL else jnp.linalg.solve(middle - low @ upper, rhs)
        now = solved[:, :k], solved[:, k]
        return now, now

    def up(below, row):
        upper, right = row
        x = right - upper @ below
        return x, x

    zeros = jnp.zeros(k)
    _, rows = lax.scan(down, (jnp.zeros((k, k)), zeros), (low, middle, high, jnp.pad(rhs, (0, spare)).reshape(-1, k)))
    return lax.scan(up, zeros, rows, reverse=True)[1].ravel()[:n]


def _iterate(matrix: MatrixFree, rhs, symmetric: bool):
    """Conjugate gradients, or GMRES where the matrix is not symmetric, with the diagonal as preconditioner."""
    import lineax  # not before it is needed: that takes a quarter of a second

    diagonal = jnp.broadcast_to(matrix.diagonal, rhs.shape)
    size = jnp.sqrt(jnp.where(diagonal == 0, 1.0, jnp.abs(diagonal)))
    scaled = rhs / size
    # lineax measures entry by entry, in which a zero of the right side ends it at once: a measure of the whole instead
    largest = jnp.abs(scaled).max()
    largest = jnp.where(largest == 0, 1.0, largest)
    tags = lineax.positive_semidefinite_tag if symmetric else ()
    method = lineax.CG if symmetric else lineax.GMRES
    solution = lineax.linear_solve(
        lineax.FunctionLinearOperator(lambda x: matrix.product(x / size) / size, jax.eval_shape(lambda: rhs), tags),
        scaled / largest,
        method(rtol=0.0, atol=ITERATIVE_TOLERANCE, max_steps=ITERATIVE_STEPS),
        throw=False,
    ).value
    return largest * solution / size


def solve(matrix, rhs, symmetric: bool = True):
    """Solution x (n,) of matrix x = rhs; ``symmetric`` matters to a matrix-free one alone."""
    match _form(matrix):
        case Form.BAND if matrix.half_bandwidth == 1:
            return _solve_tridiagonal(matrix.bands, rhs)
        case Form.BAND if matrix.half_bandwidth > 1:
            return _solve_banded(matrix.bands, rhs)
        case Form.BAND:
            return rhs / matrix.bands[0]
        case Form.FULL:
            return eliminate(matrix, rhs) if len(rhs) <= SMALL else jnp.linalg.solve(matrix, rhs)
        case Form.FREE:
            return _iterate(matrix, rhs, symmetric)
        case _:
            return rhs / matrix
