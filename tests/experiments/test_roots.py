"""Roots that Newton's iteration finds from several first guesses."""

import numpy as np
import pytest

from study.experiments.roots import roots


def test_newton_finds_the_root_that_its_start_is_near():
    grid = {"first": -2.0, "last": 2.0, "count": 9}
    ds = roots("double_well", ["houbolt"], {"first": 1, "last": 3, "count": 5}, grid, 2.5, [1e-3], steps=20)
    at_rest = ds.root.sel(scheme="houbolt", predictor=0.0)
    # the roots of u + c p(u) = 0 with c = 3.125 are 0 and ±√(1 − 2/c)
    assert set(np.round(at_rest.dropna("guess").values, 9)) == {-0.6, 0.0, 0.6}
    # they merge at c = 2, where Δt = 2
    assert ds.unique_up_to.item() == pytest.approx(2.0)
