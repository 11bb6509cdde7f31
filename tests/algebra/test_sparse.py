"""Sparse matrices, compared with full matrices."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import sparse

from study.algebra.elimination import solve
from study.algebra.matrices import add, dense, product, times
from study.algebra.sparse import Pattern, Sparse


def _random(n, symmetric, seed=0):
    """A sparse matrix whose diagonal exceeds the sum of the other entries of its row, and its pattern."""
    matrix = sparse.random_array((n, n), density=0.1, rng=np.random.default_rng(seed))
    matrix = matrix + matrix.T if symmetric else matrix
    matrix = sparse.csc_array(matrix + sparse.diags_array(1.0 + np.asarray(abs(matrix).sum(axis=1)).ravel()))
    return matrix, Pattern(matrix, symmetric)


@pytest.fixture(params=[True, False], ids=["symmetric", "not symmetric"])
def matrices(request):
    """A sparse matrix of SciPy, and the same matrix as a Sparse of the study."""
    matrix, pattern = _random(30, request.param)
    return matrix, Sparse(jnp.asarray(pattern.values(matrix)), pattern)


def test_algebra_agrees_with_that_of_full_matrices(matrices):
    full, matrix = matrices[0].toarray(), matrices[1]
    x = np.random.default_rng(1).normal(size=30)
    np.testing.assert_allclose(dense(matrix, 30), full)
    np.testing.assert_allclose(times(matrix, x), full @ x, rtol=1e-13)
    np.testing.assert_allclose(jax.jit(Sparse.scattered_times)(matrix, x), full @ x, rtol=1e-13)
    np.testing.assert_allclose(times(matrix.transposed(), x), full.T @ x, rtol=1e-13)
    np.testing.assert_allclose(dense(add(matrix, x, 2.0, matrix, n=30), 30), 2 * full + np.diag(x + 2))
    np.testing.assert_allclose(dense(product(0.5, matrix, 30), 30), full / 2)
    np.testing.assert_allclose(solve(matrix, x), np.linalg.solve(full, x), rtol=1e-12)


def test_lanes_are_solved_one_by_one(matrices):
    rhs = np.random.default_rng(2).normal(size=(3, 30))
    np.testing.assert_allclose(
        jax.jit(jax.vmap(lambda b: solve(matrices[1], b)))(rhs),
        np.linalg.solve(matrices[0].toarray(), rhs.T).T,
        rtol=1e-12,
    )


@pytest.mark.slow
@pytest.mark.parametrize("differentiate", [jax.jacfwd, jax.jacrev])
def test_solutions_and_products_are_differentiated(matrices, differentiate):
    matrix, sparse_matrix = matrices
    rhs = np.random.default_rng(3).normal(size=30)

    def scaled(factor, operation):
        return operation(Sparse(sparse_matrix.values * factor, sparse_matrix.pattern), rhs * factor**2)

    solution_slope = differentiate(lambda factor: scaled(factor, solve))(1.0)
    np.testing.assert_allclose(solution_slope, np.linalg.solve(matrix.toarray(), rhs), rtol=1e-11)  # d(x f)/df = x
    product_slope = differentiate(lambda factor: scaled(factor, times))(1.0)
    np.testing.assert_allclose(product_slope, 3 * (matrix @ rhs), rtol=1e-11)  # d(f³ A b)/df


@pytest.mark.slow
def test_patterns_with_the_same_places_are_equal():
    (matrix, pattern), (_, other) = _random(20, True), _random(20, True, seed=1)
    assert pattern == Pattern(2 * matrix, True) and hash(pattern) == hash(Pattern(matrix, True))
    assert pattern != other and pattern != Pattern(matrix, False)
