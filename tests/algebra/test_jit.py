"""Programs with the options for marches."""

import jax.numpy as jnp
import numpy as np
import pytest

from study.algebra.jit import jit, short_runs


def test_short_runs_have_their_own_programs_with_the_same_results(compiled):
    function, x = jit(lambda x: jnp.sum(jnp.sin(x) ** 2)), np.arange(5.0)
    exact = pytest.approx(np.sum(np.sin(x) ** 2), rel=1e-14)
    with short_runs():
        assert function(x) == exact
    count = len(compiled)
    assert count and function(x) == exact and len(compiled) == count + 1
    with short_runs():
        function(x)
    function(x)
    assert len(compiled) == count + 1
