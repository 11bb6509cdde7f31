"""Matrices of every form, against the same matrices as dense NumPy arrays."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.algebra import elimination
from study.algebra import matrices as linear
from study.algebra.matrices import Banded, MatrixFree

FORMS = ["number", "diagonal", "tridiagonal", "pentadiagonal", "dense", "matrix_free"]


HALF_BANDWIDTHS = {"tridiagonal": 1, "pentadiagonal": 2}


SEEDS = st.integers(0, 2**32 - 1)


_times = eqx.filter_jit(linear.times)


_dense = eqx.filter_jit(linear.dense)


def _band_of(matrix, k):
    """(2k + 1, n), entry by entry as the docstring of Banded says."""
    n = len(matrix)
    bands = np.zeros((2 * k + 1, n))
    for i in range(n):
        for j in range(max(i - k, 0), min(i + k + 1, n)):
            bands[k + j - i, i] = matrix[i, j]
    return bands


def _dominant(rng, n, k):
    """Entries within k of a diagonal that outweighs them: no elimination needs to pivot."""
    matrix = np.where(np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= k, rng.uniform(-1, 1, (n, n)), 0.0)
    return matrix + (2 * k + 1) * np.diag(rng.choice([-1.0, 1.0], n))


def _matrix(form, n, rng):
    """A matrix of the form, and the same as a dense one."""
    whole = _dominant(rng, n, HALF_BANDWIDTHS.get(form, n if form in ("dense", "matrix_free") else 0))
    match form:
        case "number":
            return jnp.asarray(whole[0, 0]), whole[0, 0] * np.eye(n)
        case "diagonal":
            return jnp.asarray(np.diag(whole)), whole
        case "tridiagonal":
            return Banded(tuple(jnp.asarray(_band_of(whole, 1)))), whole
        case "pentadiagonal":
            return Banded(jnp.asarray(_band_of(whole, 2))), whole
        case "dense":
            return jnp.asarray(whole), whole
    return _matrix_free(whole), whole


def _matrix_free(whole):
    return MatrixFree(eqx.Partial(jnp.matmul, jnp.asarray(whole)), jnp.asarray(np.diag(whole).copy()))


@eqx.filter_jit
def _columns(matrix, n):
    return jax.vmap(lambda x: linear.times(matrix, x), out_axes=1)(jnp.eye(n))


@eqx.filter_jit
def _sum_and_product(one, other, n):
    return [_columns(combine(one, other, n=n), n) for combine in (linear.add, linear.product)]


@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, n=st.sampled_from([1, 2, 9]))
def test_times_is_the_product_with_a_vector(form, seed, n):
    rng = np.random.default_rng(seed)
    matrix, whole = _matrix(form, n, rng)
    x = rng.normal(size=n)
    np.testing.assert_allclose(_times(matrix, jnp.asarray(x)), whole @ x, atol=1e-13)


@pytest.mark.parametrize("one", FORMS)
@pytest.mark.parametrize("other", FORMS)
def test_sums_and_products_of_any_two_forms(one, other):
    rng, n = np.random.default_rng(0), 7
    (first, first_whole), (second, second_whole) = _matrix(one, n, rng), _matrix(other, n, rng)
    total, product = _sum_and_product(first, second, n)
    np.testing.assert_allclose(total, first_whole + second_whole, atol=1e-13)
    np.testing.assert_allclose(product, first_whole @ second_whole, atol=1e-12)


def test_a_sum_of_many_forms():
    rng = np.random.default_rng(0)
    matrices, wholes = zip(*(_matrix(form, 6, rng) for form in FORMS[:-1]), strict=True)
    np.testing.assert_allclose(linear.add(*matrices, n=6), sum(wholes), atol=1e-13)


def test_sums_and_products_keep_to_the_least_form():
    rng, n = np.random.default_rng(1), 8
    number, diagonal, three, five = (_matrix(form, n, rng)[0] for form in FORMS[:4])
    assert linear.product(number, diagonal, n).shape == linear.add(number, diagonal, n=n).shape == (n,)
    assert linear.add(diagonal, three, n=n).half_bandwidth == linear.product(diagonal, three, n).half_bandwidth == 1
    assert linear.add(three, five, n=n).half_bandwidth == 2
    assert linear.product(three, five, n).half_bandwidth == 3


def test_one_unknown_has_numbers():
    """Which n = 0 stands for."""
    assert linear.add(2.0, 3.0, n=0) == 5.0
    assert linear.product(2.0, 3.0, 0) == 6.0
    assert elimination.solve(4.0, 2.0) == 0.5


@pytest.mark.parametrize("form", FORMS[:-1])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_every_form_but_one_can_be_written_out(form, n):
    """A band may be wider than the matrix."""
    matrix, whole = _matrix(form, n, np.random.default_rng(n))
    np.testing.assert_array_equal(_dense(matrix, n), whole)


@pytest.mark.parametrize("n, half_bandwidth", [(9, 0), (9, 1), (9, 2), (20, 5)])
def test_a_matrix_becomes_a_band_and_comes_back(n, half_bandwidth):
    whole = _dominant(np.random.default_rng(n), n, half_bandwidth)
    band = linear.banded(whole, 0)
    np.testing.assert_array_equal(band.bands, _band_of(whole, half_bandwidth))
    np.testing.assert_array_equal(_dense(band, n), whole)


def test_a_band_is_as_wide_as_asked_at_least():
    assert linear.banded(np.eye(9), 2).half_bandwidth == 2


def test_a_wide_band_stays_a_matrix():
    whole = _dominant(np.random.default_rng(0), 9, 3)
    assert linear.banded(whole, 1) is whole
