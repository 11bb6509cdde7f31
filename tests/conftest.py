"""Strictness that holds for every test, and what several of them use."""

import jax
import pytest

import study

jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")


@pytest.fixture(params=list(study.schemes))
def scheme_name(request) -> str:
    """The name of every scheme in turn."""
    return request.param


@pytest.fixture
def scheme(scheme_name) -> study.Scheme:
    """Every scheme in turn."""
    return study.schemes[scheme_name]
