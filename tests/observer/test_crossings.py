"""Oscillations counted by their upward crossings."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.observer.crossings import Oscillations, _crossing

OMEGA = 2 * np.pi


HARMONIC = study.Problem(lambda u: OMEGA**2 * u, potential=lambda u: OMEGA**2 * u * u / 2, u0=1.0, title="harmonic")


def _period(scheme, dt):
    """Period of the scheme on the harmonic oscillator, by linear theory."""
    half = OMEGA * dt / 2
    return np.pi * dt / {"average_acceleration": np.arctan, "central_difference": np.arcsin}[scheme](half)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "central_difference"])
@pytest.mark.parametrize("double, accuracy", [(True, 3e-11), (False, 1e-7)])
def test_the_period_is_that_of_linear_theory(scheme, double, accuracy):
    dt = 2.0**-6
    with jax.enable_x64(double):
        ds = study.run(HARMONIC, scheme, dt=dt, steps=2_000_000, observe=["oscillations"])
    period = _period(scheme, dt)
    # from rest the first upward crossing comes at three quarters of the period
    assert ds.crossings == np.floor(2_000_000 * dt / period + 0.25)
    assert ds.mean_period.item() == pytest.approx(period, rel=accuracy)
    last = (ds.crossings.item() - 0.25) * period / dt
    # single precision loses digits of the phase over 31,250 periods; in double precision only the interpolation errs
    assert ds.last_crossing_step.item() + ds.last_crossing_part.item() == pytest.approx(last, abs=1e-4 if double else 2)
    assert ds.last_crossing_step % 1 == 0 and 0 < ds.last_crossing_part <= 1


@pytest.mark.slow
def test_steps_beyond_the_digits_of_single_precision_are_counted():
    steps = 2**24 + 5
    # at its stability limit, ωΔt = 2, central difference alternates between −½ and ½ without round-off
    problem = study.Problem(lambda u: 4.0 * u, u0=-0.5, v0=0.0)
    with jax.enable_x64(False):
        ds = study.run(problem, "central_difference", dt=1.0, steps=steps, observe=["oscillations"])
    assert ds.crossings == steps // 2 + 1
    assert ds.last_crossing_step == steps - 1 and ds.last_crossing_part == 0.5


def test_lanes_and_unknowns_oscillate_on_their_own():
    problem = study.Problem(lambda u: jnp.asarray([1.0, 4.0]) * OMEGA**2 * u, u0=[1.0, 1.0], tangent="diagonal")
    arguments = {"steps": 4000, "observe": ["oscillations"]}
    dt = np.array([0.001, 0.002])
    lanes = study.run(problem, "average_acceleration", dt=dt, **arguments)
    assert lanes.crossings.dims == ("lane", "component")
    np.testing.assert_array_equal(lanes.crossings, [[4, 8], [8, 16]])
    np.testing.assert_allclose(lanes.mean_period, [[1.0, 0.5]] * 2, rtol=1e-4)
    np.testing.assert_allclose(
        study.run(problem, "average_acceleration", dt=0.002, **arguments).mean_period, lanes.mean_period[1], rtol=1e-12
    )


@pytest.mark.slow
def test_a_level_that_is_crossed_once_has_no_mean_period():
    ds = study.run(HARMONIC, "rk4", dt=0.01, steps=100, observe=[Oscillations()])
    assert ds.crossings == 1 and np.isnan(ds.mean_period)
    assert ds.last_crossing_step + ds.last_crossing_part == pytest.approx(75, abs=1e-4)
    above = study.run(HARMONIC, "rk4", dt=0.01, steps=300, observe=[Oscillations(level=2.0)])
    assert above.crossings == 0 and np.isnan(above.mean_period)
    high = study.run(HARMONIC, "rk4", dt=0.01, steps=300, observe=[Oscillations(level=0.5)])
    assert high.last_crossing_step + high.last_crossing_part == pytest.approx(200 + 500 / 6, abs=1e-4)


def test_a_crossing_never_leaves_its_step():
    """The crossing lies within its step, even if the velocities at its ends are zero, negative, or far too large."""
    for start in (0.0, -5.0, 1e9, 1e-300):
        for end in (0.0, -5.0, 1e9, 1e-300):
            part = _crossing((jnp.asarray(-0.2), jnp.asarray(start)), (jnp.asarray(0.3), jnp.asarray(end)), 0.1, 0.0)
            assert 0 <= part <= 1
