"""Sums and products of matrices of every form except sparse, compared with dense NumPy arrays."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.algebra import elimination
from study.algebra import matrices as linear

FORMS = ["number", "diagonal", "tridiagonal", "pentadiagonal", "dense", "matrix_free"]


SEEDS = st.integers(0, 2**32 - 1)


_times = eqx.filter_jit(linear.times)


_dense = eqx.filter_jit(linear.dense)


@eqx.filter_jit
def _columns(matrix, n):
    return jax.vmap(lambda x: linear.times(matrix, x), out_axes=1)(jnp.eye(n))


@eqx.filter_jit
def _sum_and_product(first, second, n):
    return [_columns(combine(first, second, n=n), n) for combine in (linear.add, linear.product)]


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, n=st.sampled_from([1, 2, 9]))
def test_times_is_the_product_with_a_vector(make, form, seed, n):
    rng = np.random.default_rng(seed)
    matrix, full = make.matrix(form, n, rng)
    x = rng.normal(size=n)
    np.testing.assert_allclose(_times(matrix, jnp.asarray(x)), full @ x, atol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("left", FORMS)
@pytest.mark.parametrize("right", FORMS)
def test_sums_and_products_of_any_two_forms(make, left, right):
    rng, n = np.random.default_rng(0), 7
    (first, first_whole), (second, second_whole) = make.matrix(left, n, rng), make.matrix(right, n, rng)
    total, product = _sum_and_product(first, second, n)
    np.testing.assert_allclose(total, first_whole + second_whole, atol=1e-13)
    np.testing.assert_allclose(product, first_whole @ second_whole, atol=1e-12)


def test_a_sum_of_many_forms(make):
    rng = np.random.default_rng(0)
    matrices, wholes = zip(*(make.matrix(form, 6, rng) for form in FORMS[:-1]), strict=True)
    np.testing.assert_allclose(linear.add(*matrices, n=6), sum(wholes), atol=1e-13)


@pytest.mark.slow
def test_sums_and_products_keep_to_the_least_form(make):
    rng, n = np.random.default_rng(1), 8
    number, diagonal, three, five = (make.matrix(form, n, rng)[0] for form in FORMS[:4])
    assert linear.product(number, diagonal, n).shape == linear.add(number, diagonal, n=n).shape == (n,)
    assert linear.add(diagonal, three, n=n).half_bandwidth == linear.product(diagonal, three, n).half_bandwidth == 1
    assert linear.add(three, five, n=n).half_bandwidth == 2
    assert linear.product(three, five, n).half_bandwidth == 3


def test_one_unknown_has_numbers():
    """Matrices of a single unknown are numbers. Their sums and products are computed with n = 0."""
    assert linear.add(2.0, 3.0, n=0) == 5.0
    assert linear.product(2.0, 3.0, 0) == 6.0
    assert elimination.solve(4.0, 2.0) == 0.5


@pytest.mark.parametrize("form", FORMS[:-1])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_every_form_but_one_can_be_written_out(make, form, n):
    """Every form except matrix-free becomes a dense matrix, even if a band is wider than the matrix."""
    matrix, full = make.matrix(form, n, np.random.default_rng(n))
    np.testing.assert_array_equal(_dense(matrix, n), full)


@pytest.mark.parametrize("n, half_bandwidth", [(9, 0), (9, 1), (9, 2), (20, 5)])
def test_a_matrix_becomes_a_band_and_comes_back(make, n, half_bandwidth):
    full = make.dominant(np.random.default_rng(n), n, half_bandwidth)
    band = linear.banded(full, 0)
    assert isinstance(band, linear.Banded)
    np.testing.assert_array_equal(band.bands, make.band_of(full, half_bandwidth))
    np.testing.assert_array_equal(_dense(band, n), full)


def test_a_band_is_as_wide_as_asked_at_least():
    band = linear.banded(np.eye(9), 2)
    assert isinstance(band, linear.Banded) and band.half_bandwidth == 2


def test_a_wide_band_stays_a_matrix(make):
    full = make.dominant(np.random.default_rng(0), 9, 3)
    assert linear.banded(full, 1) is full
