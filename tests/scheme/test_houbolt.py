"""The starts of Houbolt's method."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem.springs import CubicSpring
from study.scheme.houbolt import starts


def _trajectory(scheme, problem="hardening", dt=0.15 / 40, steps=200):
    return study.run(problem, scheme, dt=dt, steps=steps).u.values


def test_houbolt_starts_with_the_linear_acceleration_method():
    dt = 0.15 / 20
    houbolt, linear = (_trajectory(s, dt=dt, steps=1) for s in (study.Houbolt(), study.Newmark(beta=1 / 6, gamma=0.5)))
    np.testing.assert_allclose(houbolt, linear, rtol=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("damping", [None, 3.0])
def test_houbolt_started_by_central_difference_takes_two_of_its_steps(damping):
    problem = study.Problem(CubicSpring(100.0, 10.0).force, u0=1.5, v0=2.0, damping=damping)
    dt = 0.15 / 20
    houbolt = _trajectory(study.Houbolt(start_by="central_difference"), problem, dt, 2)
    np.testing.assert_allclose(houbolt, _trajectory("central_difference", problem, dt, 2), rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("start", starts)
def test_every_start_of_houbolt_keeps_the_second_order(start):
    period = 0.151532834447260357127078726219
    errors = [
        abs(study.run("hardening", study.Houbolt(start_by=start), dt=period / 4 / n, steps=n).u.values[-1])
        for n in (800, 1600, 3200)
    ]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2, abs=0.1)


def test_exact_start_of_houbolt_is_exact():
    """From rest the exact displacements before the start equal the displacements after it."""
    problem, dt = study.problems["hardening"], 0.15 / 20
    u_1, u_2, _ = starts["exact"](problem, jnp.asarray(1.5), jnp.asarray(0.0), dt)
    fine = study.run(problem, "rk4", dt=dt / 512, steps=1024, every=512).u.values
    np.testing.assert_allclose([u_1, u_2], fine[1:], rtol=1e-11)


def test_an_unknown_start_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean 'taylor'"):
        study.Houbolt(start_by="tailor")
