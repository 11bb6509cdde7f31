"""Solution of linear systems: by elimination that suits the form of the matrix, by iteration if it is matrix-free."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from study.algebra.arrays import Full, Matrix, RightSides, Vector
from study.algebra.counting import count_matrix
from study.algebra.factorisation import factorisations
from study.algebra.host import on_host
from study.algebra.matrices import Form, MatrixFree, form_of
from study.algebra.sparse import Sparse

#: Largest numbers of unknowns of a full system for which elimination is written out, and for which it is a loop. A loop
#: of steps that calls LAPACK instead is not one native loop.
WRITTEN_OUT, IN_LOOP = 4, 16

#: Number of rows of a tridiagonal system that one pass of the loop eliminates.
UNROLL = 4

#: Tolerance of the iterative solution of a matrix-free system, relative to the largest entry of the right side. The
#: second number is the largest number of iterations of conjugate gradients, and of restarts of GMRES.
ITERATIVE_TOLERANCE, ITERATIVE_STEPS = 1e-10, 10_000


def eliminate(matrix: Full, *right_sides: RightSides) -> list[RightSides]:
    """Solve a small system by Gaussian elimination with partial pivoting, written out without a loop.

    Right sides that stay apart have solutions that are linear in each of them for JAX too.

    Parameters
    ----------
    matrix
        Matrix of the system, (n, n).
    right_sides
        Right sides, each (n,) or (n, m).
    """
    left, rights, rows = matrix, [rhs.reshape(len(rhs), -1) for rhs in right_sides], []
    for k in range(len(matrix)):
        is_pivot = (jnp.arange(len(matrix) - k) == jnp.argmax(jnp.abs(left[:, 0])))[:, None]
        pivots, (left, *rights) = zip(*(_pivot_and_others(part, is_pivot) for part in (left, *rights)), strict=True)
        factor = left[:, 0] / pivots[0][0]
        left = left[:, 1:] - jnp.multiply.outer(factor, pivots[0][1:])
        rights = [right - jnp.multiply.outer(factor, b) for right, b in zip(rights, pivots[1:], strict=True)]
        rows.append(pivots)
    solutions = []
    for number, rhs in enumerate(right_sides, start=1):
        x: list = []
        for pivots in reversed(rows):
            a, b = pivots[0], pivots[number]
            known = sum(a[1 + i] * value for i, value in enumerate(reversed(x)))
            x.append((b - known) / a[0])
        solutions.append(jnp.stack(x[::-1]).reshape(rhs.shape))
    return solutions


def _pivot_and_others(rows, is_pivot):
    """The row of the pivot, and the other rows, of which the first takes its place."""
    return jnp.where(is_pivot, rows, 0.0).sum(axis=0), jnp.where(is_pivot[1:], rows[:1], rows[1:])


def eliminate_in_loop(matrix: Full, *right_sides: RightSides) -> list[RightSides]:
    """As :func:`eliminate`, by Gauss and Jordan's elimination in a loop, which is compiled sooner but takes longer."""
    row = jnp.arange(len(matrix))

    def turn(k, parts):
        column = parts[0][:, k]
        place = jnp.argmax(jnp.where(row >= k, jnp.abs(column), -1.0))
        factor = jnp.where(row == place, column[k], column) / column[place]

        def eliminated(part):
            pivot = part[place]
            others = jnp.where((row == place)[:, None], part[k][None], part) - jnp.multiply.outer(factor, pivot)
            return jnp.where((row == k)[:, None], pivot[None] / column[place], others)

        return tuple(map(eliminated, parts))

    parts = matrix, *(rhs.reshape(len(rhs), -1) for rhs in right_sides)
    _, *solutions = lax.fori_loop(0, len(matrix), turn, parts)
    return [x.reshape(rhs.shape) for x, rhs in zip(solutions, right_sides, strict=True)]


def _solve_full(matrix, *right_sides):
    """The solution for each right side; see :func:`eliminate`."""
    if len(matrix) <= WRITTEN_OUT:
        return eliminate(matrix, *right_sides)
    if len(matrix) <= IN_LOOP:
        return eliminate_in_loop(matrix, *right_sides)
    if len(right_sides) == 1:
        return [jnp.linalg.solve(matrix, *right_sides)]
    factors = jax.scipy.linalg.lu_factor(matrix)
    return [jax.scipy.linalg.lu_solve(factors, rhs) for rhs in right_sides]


def _solve_tridiagonal(bands, rhs):
    """Solve a tridiagonal system in place by Thomas' algorithm, ``UNROLL`` rows per pass of the loop.

    The algorithm does not pivot. The matrices M + c K of a step need no pivoting if they are positive definite. Another
    matrix can give an inaccurate solution or NaN.
    """
    lower, middle, upper = bands
    n = len(rhs)
    remainder = n % UNROLL

    def down(start, size, carry):
        upper, right, above, solved = carry
        rows = (lax.dynamic_slice(x, (start,), (size,)) for x in (lower, middle, upper, right))
        eliminated = []
        for low, diagonal, high, b in zip(*rows, strict=True):
            pivot = 1 / (diagonal - low * above)
            above, solved = high * pivot, (b - low * solved) * pivot
            eliminated.append((above, solved))
        ratios, values = (jnp.stack(x) for x in zip(*eliminated, strict=True))
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
        solutions = []
        for ratio, value in reversed(list(zip(*rows, strict=True))):
            x = value - ratio * x
            solutions.append(x)
        return lax.dynamic_update_slice(right, jnp.stack(solutions[::-1]), (start,)), x

    zero = jnp.zeros((), rhs.dtype)
    carry = upper, rhs, zero, zero
    if n < UNROLL:
        upper, right, _, _ = down(0, n, carry)
        return up(0, n, (right, zero))[0]
    carry = lax.fori_loop(0, n // UNROLL, lambda i, c: down(i * UNROLL, UNROLL, c), carry)
    upper, right, _, _ = down(n - remainder, remainder, carry) if remainder else carry
    back = up(n - remainder, remainder, (right, zero)) if remainder else (right, zero)
    return lax.fori_loop(0, n // UNROLL, lambda i, c: up(n - remainder - (i + 1) * UNROLL, UNROLL, c), back)[0]


def _solve_banded(bands, rhs):
    """Solve a system of half bandwidth k by Thomas' algorithm for blocks of k by k, with pivoting within each block."""
    k, n = len(bands) // 2, len(rhs)
    blocks = -(-n // k)
    spare = blocks * k - n
    # each row of blocks has three blocks; rows beyond the last unknown are rows of the identity matrix
    padded = jnp.pad(bands, ((0, 0), (0, spare))).at[k, n:].set(1.0).T.reshape(blocks, k, 2 * k + 1)
    row, place = np.arange(k)[:, None], np.arange(2 * k + 1)
    wide = jnp.zeros((blocks, k, 3 * k)).at[:, row, row + place].set(padded)
    low, middle, high = wide[:, :, :k], wide[:, :, k : 2 * k], wide[:, :, 2 * k :]

    def down(above, row):
        upper, right = above
        low, middle, high, b = row
        eliminated = tuple(_solve_full(middle - low @ upper, high, b - low @ right))
        return eliminated, eliminated

    def up(below, row):
        upper, right = row
        x = right - upper @ below
        return x, x

    zeros = jnp.zeros(k)
    _, rows = lax.scan(down, (jnp.zeros((k, k)), zeros), (low, middle, high, jnp.pad(rhs, (0, spare)).reshape(-1, k)))
    return lax.scan(up, zeros, rows, reverse=True)[1].ravel()[:n]


def _iterate(product: Callable, diagonal, rhs, symmetric: bool):
    """Solve by conjugate gradients, or by GMRES if the matrix is not symmetric, with the diagonal as preconditioner."""
    import lineax  # imported here, because only a matrix-free solution needs it

    diagonal = jnp.broadcast_to(diagonal, rhs.shape)
    size = jnp.sqrt(jnp.where(diagonal == 0, 1.0, jnp.abs(diagonal)))
    scaled = rhs / size
    # lineax applies a relative tolerance to each entry, and stops at once if the right side has zeros. The right side
    # is scaled so that its largest entry is one; an absolute tolerance then measures the whole vector.
    largest = jnp.abs(scaled).max()
    largest = jnp.where(largest == 0, 1.0, largest)
    tags = lineax.positive_semidefinite_tag if symmetric else ()
    method = lineax.CG if symmetric else lineax.GMRES
    solution = lineax.linear_solve(
        lineax.FunctionLinearOperator(lambda x: product(x / size) / size, jax.eval_shape(lambda: rhs), tags),
        scaled / largest,
        method(rtol=0.0, atol=ITERATIVE_TOLERANCE, max_steps=ITERATIVE_STEPS),
        throw=False,
    ).value
    return largest * solution / size


def _solve_free(matrix: MatrixFree, rhs, symmetric: bool):
    def solved(product, b):
        return _iterate(product, matrix.diagonal, b, symmetric)

    # the solution is linear in the right side for JAX too, although its scale is not
    return lax.custom_linear_solve(matrix.product, rhs, solved, solved, symmetric=symmetric)


def _solve_sparse(matrix: Sparse, rhs):
    solved = factorisations(matrix.pattern).solved

    def transposed(_, b):
        return on_host(solved, b, matrix.transposed().values, b)

    return lax.custom_linear_solve(
        matrix.scattered_times,
        rhs,
        lambda _, b: on_host(solved, b, matrix.values, b),
        transposed,
        symmetric=matrix.pattern.symmetric,
    )


def solve(matrix: Matrix, rhs: Vector, symmetric: bool = True) -> Vector:
    """Solve matrix · x = rhs for x.

    Parameters
    ----------
    matrix
        n × n, in any form.
    rhs
        Right side, () or (n,).
    symmetric
        Whether the matrix is symmetric; used only for a matrix-free matrix.
    """
    form = form_of(matrix)
    if form in (Form.SPARSE, Form.FULL) or (form is Form.BAND and matrix.half_bandwidth):
        count_matrix(matrix)
    match form:
        case Form.BAND if matrix.half_bandwidth == 1:
            return _solve_tridiagonal(matrix.bands, rhs)
        case Form.BAND if matrix.half_bandwidth > 1:
            return _solve_banded(matrix.bands, rhs)
        case Form.BAND:
            return rhs / matrix.bands[0]
        case Form.SPARSE:
            return _solve_sparse(matrix, rhs)
        case Form.FULL:
            return _solve_full(matrix, rhs)[0]
        case Form.FREE:
            return _solve_free(matrix, rhs, symmetric)
        case _:
            return rhs / matrix
