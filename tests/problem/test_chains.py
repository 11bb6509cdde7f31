"""Chains of masses."""

import numpy as np
import pytest

import study
from study.problem import chains
from study.problem.named import known


@pytest.mark.slow
def test_a_soliton_keeps_its_form():
    """At t = 10 the soliton is in the middle of forty masses, far from both ends."""
    ds = study.run(chains.toda_chain(40), "rk4", dt=0.01, steps=1000, every=1000)
    for values, exact in zip((ds.u, ds.v), chains.toda_soliton(40, 10.0), strict=True):
        np.testing.assert_allclose(values[-1], exact, rtol=0, atol=1e-6)


def test_a_bar_that_moves_as_a_whole_but_for_its_wall_strains_its_last_element_alone():
    bar = study.problems["impact_bar"]
    n = bar.u0.size
    strain, h = 0.1 * n, 1 / n
    assert float(bar.potential(np.full(n, 0.1))) == pytest.approx(h * (strain**2 / 2 + 10 * strain**4 / 4))


@pytest.mark.slow
def test_central_difference_has_the_exact_motion_of_a_linear_bar():
    target = known["loaded_bar"]
    bar = study.problems["loaded_bar"]
    n = bar.u0.size
    exact = study.run(bar, "central_difference", dt=1 / n, steps=2 * n, every=n // 2)
    np.testing.assert_allclose(exact.u[-1], target.u, rtol=0, atol=1e-13)
    # the displacement of the struck end rises linearly until the reflected wave arrives
    np.testing.assert_allclose(exact.u[:, 0], exact.t, rtol=0, atol=1e-13)
    finer = study.run(bar, "central_difference", dt=0.25 / n, steps=8 * n, every=8 * n)
    assert np.abs(finer.u[-1] - target.u).max() > 1e-3
