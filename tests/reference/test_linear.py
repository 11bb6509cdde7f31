"""Exact motions of linear oscillators under records, compared with motions from event to event."""

import numpy as np

from reference import bilinear, linear
from study.mechanics.ground import GroundMotion

STIFFNESS = (2 * np.pi / np.array([0.2, 1.0])) ** 2
SAMPLES = np.stack([GroundMotion.kanai_tajimi(seed, duration=4.0).acceleration for seed in (1, 2)])


def test_motions_are_those_of_a_spring_that_does_not_yield():
    damping = 0.1 * np.sqrt(STIFFNESS)
    peak, u = linear.motions(SAMPLES, 0.02, STIFFNESS, damping)
    expected_peak, expected_u = bilinear.motions(SAMPLES, 0.02, STIFFNESS, damping, np.full(2, 1e9), 0.02, 5)
    np.testing.assert_allclose(peak, expected_peak, rtol=1e-12)
    np.testing.assert_allclose(u, expected_u, atol=1e-12 * expected_peak.max())
