"""Factorisations of sparse matrices: the choice of a method, the reuse of factors, and calls from compiled programs."""

import subprocess
import sys

import numpy as np
import pytest
from scipy import sparse

from study.algebra import factorisation
from study.algebra.factorisation import BandCholesky, Cholmod, Factorisations, SuperLU, is_positive_definite
from study.algebra.sparse import Pattern


def _mesh(width, length):
    """The stiffness of a grid of springs, fixed at its edges, with the unknowns numbered at random."""
    across, along = (sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n)) for n in (width, length))
    grid = sparse.csc_array(sparse.kron(across, sparse.eye_array(length)) + sparse.kron(sparse.eye_array(width), along))
    order = np.random.default_rng(0).permutation(width * length)
    return sparse.csc_array(grid[order][:, order])


def _chords(n):
    """The stiffness of a ring of springs with random chords; no numbering of its unknowns has a small bandwidth."""
    nodes = np.arange(n)
    ends = np.concatenate([np.roll(nodes, 1), np.random.default_rng(0).permutation(n)])
    springs = sparse.coo_array((np.ones(2 * n), (np.tile(nodes, 2), ends)), shape=(n, n))
    springs = springs + springs.T
    return sparse.csc_array(sparse.diags_array(springs.sum(axis=0) + 1.0) - springs)


@pytest.mark.parametrize(("width", "expected"), [(3, BandCholesky), (130, Cholmod)])
def test_the_method_follows_the_pattern(width, expected):
    if expected is Cholmod:
        pytest.importorskip("cvxopt", reason="the extra 'sparse' is not installed")
    matrix = _mesh(width, 140)
    pattern, rhs = Pattern(matrix, symmetric=True), np.arange(matrix.shape[0], dtype=float)
    solver = Factorisations(pattern)
    assert type(solver._methods[0]) is expected
    solution = solver.solved(pattern.values(matrix), rhs)
    np.testing.assert_allclose(matrix @ solution, rhs, atol=1e-9 * np.abs(solution).max())


def test_without_the_extra_a_wide_mesh_goes_to_superlu(monkeypatch):
    monkeypatch.setattr(factorisation, "find_spec", lambda name: None)
    pattern = Pattern(_mesh(130, 140), symmetric=True)
    assert type(Factorisations(pattern)._methods[0]) is SuperLU


@pytest.mark.parametrize(("stiffness", "expected"), [(_mesh(3, 140), BandCholesky), (_chords(1000), Cholmod)])
def test_a_matrix_that_is_not_positive_definite_is_solved_too(stiffness, expected):
    if expected is Cholmod:
        pytest.importorskip("cvxopt", reason="the extra 'sparse' is not installed")
    matrix = sparse.csc_array(stiffness - 1.37 * sparse.eye_array(stiffness.shape[0]))
    pattern, rhs = Pattern(matrix, symmetric=True), np.ones(matrix.shape[0])
    solver = Factorisations(pattern)
    assert type(solver._methods[0]) is expected
    assert is_positive_definite(stiffness) and not is_positive_definite(matrix)
    solution = solver.solved(pattern.values(matrix), rhs)
    np.testing.assert_allclose(matrix @ solution, rhs, atol=1e-8 * np.abs(solution).max())


@pytest.mark.parametrize("wrong", [0.0, np.nan])
def test_a_singular_matrix_has_no_solution(wrong):
    pattern = Pattern(_mesh(3, 10), symmetric=True)
    assert np.isnan(Factorisations(pattern).solved(np.full(len(pattern.rows), wrong), np.ones(30))).all()


@pytest.mark.parametrize("width", [3, 130])
def test_factors_are_kept_while_matrices_come_again(width):
    matrix = _mesh(width, 140)
    pattern = Pattern(matrix, symmetric=True)
    values, rhs = pattern.values(matrix), np.ones(matrix.shape[0])
    solver = Factorisations(pattern)
    for _ in range(3):
        for factor in 1.0, 2.0, 4.0:
            np.testing.assert_allclose(factor * (matrix @ solver.solved(factor * values, rhs)), rhs, atol=1e-9)
    assert solver.count == 3
    # three factorisations are kept; a new one replaces the least recently used one
    for factor in 8.0, 1.0, 8.0:
        np.testing.assert_allclose(factor * (matrix @ solver.solved(factor * values, rhs)), rhs, atol=1e-9)
    assert solver.count == 5


def test_programs_that_call_numpy_do_not_stand_still():
    """Compiled programs that call NumPy run on one core with large arrays, where jax.pure_callback would deadlock."""
    program = """
import os
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from concurrent.futures import ThreadPoolExecutor
import numpy as np, jax, study
from study.algebra.host import on_host

@jax.jit
def loop(x):
    return jax.lax.fori_loop(0, 20, lambda i, x: on_host(lambda x: x + 1.0, x, x), x)

with ThreadPoolExecutor(4) as threads:
    results = list(threads.map(lambda k: np.asarray(loop(np.full(200_000, float(k)))), range(4)))
assert all((result == k + 20).all() for k, result in enumerate(results))
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=100)
