"""The mass on a belt, compared with the pieces of its motion in closed form."""

import numpy as np

import study
from study.problem import inelastic
from study.problem.named import known


def test_the_mass_on_a_belt_slips_sticks_and_slips_again():
    target, steps = known["belt"], 4096
    ds = study.run("belt", "average_acceleration", dt=target.time / steps, steps=steps)
    phase, speed = 2 * np.pi * ds.t.values, inelastic.BELT / (2 * np.pi)
    sticks, slips = np.pi / 6, np.pi / 6 + np.sqrt(3)
    exact = np.select(
        [phase < sticks, phase < slips],
        [0.1 * (1 - np.cos(phase)), 0.1 + speed * (phase - slips)],
        0.1 + speed * np.sin(phase - slips),
    )
    np.testing.assert_allclose(ds.u + inelastic.BELT * ds.t, exact, rtol=0, atol=1e-5)
    np.testing.assert_allclose(ds.u.values[-1], target.u, rtol=2e-5)
