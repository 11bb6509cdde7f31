"""Chains of masses."""

import numpy as np
import pytest

import study
from study.problem import chains


def test_a_soliton_keeps_its_form():
    """At t = 10 it is in the middle of forty masses, far from both ends."""
    ds = study.run(chains.toda_chain(40), "rk4", dt=0.01, steps=1000, every=1000)
    for found, exact in zip((ds.u, ds.v), chains.toda_soliton(40, 10.0), strict=True):
        np.testing.assert_allclose(found[-1], exact, rtol=0, atol=1e-6)


def test_a_bar_that_moves_as_a_whole_but_for_its_wall_strains_its_last_element_alone():
    bar = study.problems["impact_bar"]
    n = bar.u0.size
    strain, h = 0.1 * n, 1 / n
    assert float(bar.potential(np.full(n, 0.1))) == pytest.approx(h * (strain**2 / 2 + 10 * strain**4 / 4))
