"""Strictness that holds for every test, and what several of them use."""

import gc

import jax
import pytest

import study

# as the pipeline's jobs do: what has been imported stays, and is not looked through for garbage again and again
gc.freeze()
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")


def pytest_collection_modifyitems(items):
    """The pipeline first: at the end it would leave every core but its own without work."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)


@pytest.fixture(scope="module", autouse=True)
def forget_programs():
    """Programs of one file of tests are of no use to the next, and thousands of them slow everything down."""
    yield
    jax.clear_caches()


@pytest.fixture(params=list(study.schemes))
def scheme_name(request) -> str:
    """The name of every scheme in turn."""
    return request.param


@pytest.fixture
def scheme(scheme_name) -> study.Scheme:
    """Every scheme in turn."""
    return study.schemes[scheme_name]


#: The first scheme of every class.
KINDS = {type(scheme): name for name, scheme in reversed(list(study.schemes.items()))}


@pytest.fixture(params=KINDS.values())
def kind(request) -> str:
    """The name of one scheme of every class in turn, where its parameters make no difference."""
    return request.param
