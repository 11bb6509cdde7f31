"""Oscillators of one unknown."""

import mpmath
import pytest

import study
from study.problem import oscillators


def test_period_of_the_pendulum_near_its_top():
    problem = oscillators.pendulum()
    speed = float(problem.v0)
    period = float(4 * mpmath.ellipk(mpmath.mpf(speed) ** 2 / 4))
    assert period == pytest.approx(33.7210, abs=5e-5)
    end = study.run(problem, "gauss4", dt=period / 2 / 4000, steps=4000, every=4000).isel(t=-1)
    assert end.u.item() == pytest.approx(0, abs=1e-5)
    assert end.v.item() == pytest.approx(-speed, abs=1e-9)
