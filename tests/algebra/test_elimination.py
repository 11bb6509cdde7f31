"""Solutions of linear systems with matrices of every form except sparse, compared with NumPy's solutions."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.algebra import elimination
from study.algebra.matrices import Banded

FORMS = ["number", "diagonal", "tridiagonal", "pentadiagonal", "dense", "matrix_free"]


SEEDS = st.integers(0, 2**32 - 1)


ELIMINATIONS = {name: jax.jit(getattr(elimination, name)) for name in ("eliminate", "eliminate_in_loop")}


@eqx.filter_jit
def _solve(matrix, rhs, symmetric=True):
    return elimination.solve(matrix, rhs, symmetric)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=15, deadline=None)
@given(seed=SEEDS, n=st.sampled_from([3, 6]))
def test_solve_undoes_times(make, form, seed, n):
    rng = np.random.default_rng(seed)
    matrix, full = make.matrix(form, n, rng)
    rhs = rng.uniform(0.5, 1.5, n)
    np.testing.assert_allclose(_solve(matrix, jnp.asarray(rhs), False), np.linalg.solve(full, rhs), atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 7, 8, 13])
def test_tridiagonal_elimination_of_any_length(make, n):
    """The loop eliminates four rows per iteration; lengths below four, multiples of four and others are tested."""
    rng = np.random.default_rng(n)
    full, rhs = make.dominant(rng, n, 1), rng.normal(size=n)
    for bands in (make.band_of(full, 1), tuple(make.band_of(full, 1))):
        solution = _solve(Banded(jax.tree.map(jnp.asarray, bands)), jnp.asarray(rhs))
        np.testing.assert_allclose(solution, np.linalg.solve(full, rhs), rtol=1e-12, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("half_bandwidth", [2, 3, 7])
@pytest.mark.parametrize("more", [1, 6, 8])
def test_elimination_of_blocks(make, half_bandwidth, more):
    """The last block may be complete or incomplete; blocks of more than four unknowns are eliminated in a loop."""
    n = half_bandwidth + more
    rng = np.random.default_rng(n)
    full, rhs = make.dominant(rng, n, half_bandwidth), rng.normal(size=n)
    solution = _solve(Banded(jnp.asarray(make.band_of(full, half_bandwidth))), jnp.asarray(rhs))
    np.testing.assert_allclose(solution, np.linalg.solve(full, rhs), rtol=1e-11, atol=1e-13)


def test_a_block_is_pivoted(make):
    """All diagonal entries are zero, so that elimination without pivots would divide by zero."""
    full = np.kron(np.eye(3), [[0.0, 2.0], [1.0, 0.0]]) + np.diag(np.full(4, 0.1), 2)
    rhs = np.arange(1.0, 7.0)
    solution = _solve(Banded(jnp.asarray(make.band_of(full, 2))), jnp.asarray(rhs))
    np.testing.assert_allclose(solution, np.linalg.solve(full, rhs), rtol=1e-13)


def test_one_diagonal_divides():
    matrix = Banded(jnp.array([[2.0, 4.0, 5.0]]))
    np.testing.assert_array_equal(elimination.solve(matrix, jnp.array([2.0, 2.0, 10.0])), [1.0, 0.5, 2.0])


@settings(max_examples=15, deadline=None)
@given(seed=SEEDS)
def test_conjugate_gradients_of_a_symmetric_matrix(make, seed):
    rng, n = np.random.default_rng(seed), 8
    root = rng.normal(size=(n, n))
    full = root @ root.T + np.diag(rng.uniform(1, 100, n))
    rhs = rng.uniform(0.5, 1.5, n)
    solution = _solve(make.matrix_free(full), jnp.asarray(rhs), True)
    np.testing.assert_allclose(full @ np.asarray(solution), rhs, atol=1e-8)


@settings(max_examples=15, deadline=None)
@given(seed=SEEDS)
def test_gmres_of_any_matrix(make, seed):
    rng, n = np.random.default_rng(seed), 8
    full, rhs = make.dominant(rng, n, n), rng.uniform(0.5, 1.5, n)
    solution = _solve(make.matrix_free(full), jnp.asarray(rhs), False)
    np.testing.assert_allclose(full @ np.asarray(solution), rhs, atol=1e-8)


@pytest.mark.parametrize("symmetric", [True, False])
def test_a_force_at_one_place_is_felt_at_all(make, symmetric):
    """If the right side has a single non-zero entry, the iterative solution is accurate at all unknowns."""
    n = 6
    full = 2.1 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    solution = _solve(make.matrix_free(full), jnp.asarray(np.eye(n)[0]), symmetric)
    np.testing.assert_allclose(solution, np.linalg.solve(full, np.eye(n)[0]), atol=1e-9)


def test_a_right_side_of_zeros_has_the_solution_zero(make):
    full = 2.1 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    np.testing.assert_array_equal(_solve(make.matrix_free(full), jnp.zeros(6), True), np.zeros(6))


@pytest.mark.slow
@pytest.mark.parametrize("name", ELIMINATIONS)
@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, n=st.sampled_from([1, 2, 4, 9]), sides=st.sampled_from([None, 3]))
def test_eliminate_takes_several_right_sides(name, seed, n, sides):
    rng = np.random.default_rng(seed)
    full = np.linalg.qr(rng.normal(size=(n, n)))[0]
    rhs = rng.normal(size=n if sides is None else (n, sides))
    [solution] = ELIMINATIONS[name](jnp.asarray(full), jnp.asarray(rhs))
    np.testing.assert_allclose(solution, np.linalg.solve(full, rhs), atol=1e-12)


@pytest.mark.parametrize("name", ELIMINATIONS)
def test_eliminate_pivots(name):
    full = np.array([[0.0, 0.0, 3.0], [2.0, 0.0, 1.0], [1.0, 4.0, 1.0]])
    rhs = np.array([3.0, 5.0, 10.0])
    [solution] = ELIMINATIONS[name](jnp.asarray(full), jnp.asarray(rhs))
    np.testing.assert_allclose(solution, np.linalg.solve(full, rhs))


@pytest.mark.parametrize("n", [4, 7, 16, 17])
def test_a_full_system_of_any_size_is_solved(n):
    """Written out, in a loop, and by LAPACK."""
    full, rhs = np.random.default_rng(n).normal(size=(n, n)), np.arange(1.0, n + 1)
    np.testing.assert_allclose(_solve(jnp.asarray(full), jnp.asarray(rhs)), np.linalg.solve(full, rhs), rtol=1e-9)


@pytest.mark.parametrize("form", ["tridiagonal", "pentadiagonal", "dense", "matrix_free"])
def test_solutions_have_derivatives_in_reverse_mode(make, form):
    """The gradient of the sum of a solution by its right side is the solution of the transposed system."""
    matrix, full = make.matrix(form, 6, np.random.default_rng(3))
    gradient = jax.grad(lambda rhs: _solve(matrix, rhs, False).sum())(jnp.arange(1.0, 7.0))
    np.testing.assert_allclose(gradient, np.linalg.solve(full.T, np.ones(6)), atol=1e-9)
