"""Chains of masses."""

import numpy as np

import study
from study.problem import chains


def test_a_soliton_keeps_its_form():
    """At t = 10 it is in the middle of forty masses, far from both ends."""
    ds = study.run(chains.toda_chain(40), "rk4", dt=0.01, steps=1000, every=1000)
    for found, exact in zip((ds.u, ds.v), chains.toda_soliton(40, 10.0), strict=True):
        np.testing.assert_allclose(found[-1], exact, rtol=0, atol=1e-6)
