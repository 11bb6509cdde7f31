"""Test matrices of every form except sparse, each together with the same matrix as a dense NumPy array."""

from types import SimpleNamespace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from study.algebra.matrices import Banded, MatrixFree

HALF_BANDWIDTHS = {"tridiagonal": 1, "pentadiagonal": 2}


def _band_of(matrix, k):
    """The 2k + 1 diagonals of a matrix as an array (2k + 1, n), in the layout that the docstring of Banded defines."""
    n = len(matrix)
    bands = np.zeros((2 * k + 1, n))
    for i in range(n):
        for j in range(max(i - k, 0), min(i + k + 1, n)):
            bands[k + j - i, i] = matrix[i, j]
    return bands


def _dominant(rng, n, k):
    """A random matrix of half bandwidth k whose diagonal dominates, so that elimination needs no pivots."""
    matrix = np.where(np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= k, rng.uniform(-1, 1, (n, n)), 0.0)
    return matrix + (2 * k + 1) * np.diag(rng.choice([-1.0, 1.0], n))


def _matrix(form, n, rng):
    """A random matrix in the form ``form``, and the same matrix as a dense NumPy array."""
    full = _dominant(rng, n, HALF_BANDWIDTHS.get(form, n if form in ("dense", "matrix_free") else 0))
    match form:
        case "number":
            return jnp.asarray(full[0, 0]), full[0, 0] * np.eye(n)
        case "diagonal":
            return jnp.asarray(np.diag(full)), full
        case "tridiagonal":
            return Banded(tuple(jnp.asarray(_band_of(full, 1)))), full
        case "pentadiagonal":
            return Banded(jnp.asarray(_band_of(full, 2))), full
        case "dense":
            return jnp.asarray(full), full
    return _matrix_free(full), full


def _matrix_free(full):
    return MatrixFree(eqx.Partial(jnp.matmul, jnp.asarray(full)), jnp.asarray(np.diag(full).copy()))


@pytest.fixture(scope="session")
def make():
    """The functions of this file that make matrices, for the tests of this folder."""
    return SimpleNamespace(band_of=_band_of, dominant=_dominant, matrix=_matrix, matrix_free=_matrix_free)
