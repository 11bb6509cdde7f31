"""Trusses."""

import numpy as np
import pytest

import study
from study.problem import trusses


@pytest.mark.slow
def test_a_cantilever_comes_to_rest_where_its_forces_balance(small_truss):
    light = trusses.cantilever_truss()
    heavy = study.Problem(
        potential=light.potential, u0=light.u0, v0=light.v0, damping=study.Rayleigh(a=4.0, b=0.01), load=light.load,
        tangent=light.tangent,
    )  # fmt: skip
    end = study.run(heavy, "average_acceleration", dt=0.1, steps=200, every=200).isel(t=-1)
    assert np.abs(end.u).max() > 1e-3
    np.testing.assert_allclose(heavy.force(end.u.values), light.load(0.0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(end.v, 0, atol=1e-10)
