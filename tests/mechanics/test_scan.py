"""Times at which loads jump, have kinks or act for a moment, against the times by which the loads are defined."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.mechanics.loads import times_of
from study.mechanics.scan import events

TABLE = np.array([0.0, 3.3, 3.300005, 3.30001, 20.0]), np.array([0.0, 0.0, 2e5, 0.0, 0.0])
RECORD = 8 + 0.02 * np.arange(50), np.append(np.random.default_rng(0).standard_normal(49), 0.0)
#: A number that a program computes, so that it is not one of its numbers.
SECRET = np.sqrt(2.0) * 4


@pytest.mark.slow
@pytest.mark.parametrize(
    "load, expected",
    [
        (lambda t: jnp.where((t >= 8) & (t < 8.02), 50.0, 0.0), [8, 8.02]),
        (lambda t: jnp.where((t >= 3.3) & (t < 3.3 + 1e-5), 1e5, 0.0), [3.3, 3.30001]),
        (lambda t: jnp.where(t**2 > SECRET**2, 1.0, 0.0), [SECRET]),
        (lambda t: 50 * jnp.maximum(0, 1 - jnp.abs(t - 8) / 0.01), [7.99, 8, 8.01]),
        (lambda t: jnp.where((t > 8) & (t < 8.02), jnp.sin(jnp.pi * (t - 8) / 0.02), 0.0), [8, 8.01, 8.02]),
        (lambda t: jnp.maximum(0.0, t - 7.77), [7.77]),
        (lambda t: jnp.sin(3 * t) + jnp.where((t >= 8) & (t < 8.02), 5.0, 0.0), [8, 8.02]),
        (lambda t: jnp.interp(t, *TABLE), TABLE[0][1:-1]),
        (lambda t: jnp.interp(t, *RECORD, left=0.0), RECORD[0]),
        (lambda t: jnp.abs(jnp.sin(2 * t)), np.pi / 2 * np.arange(1, 13)),
        (lambda t: jnp.ones(200) * jnp.where((t >= 8) & (t < 8.02), 50.0, 0.0), [8, 8.02]),
    ],
)
def test_jumps_and_kinks_are_found(load, expected):
    times = events(load, 20.0)
    assert all(np.abs(times - time).min() < 1e-9 for time in expected)
    # in addition, one time may lie between two neighbouring ones
    assert len(times) <= 2 * len(expected) - 1


def test_a_train_of_pulses_is_found_whole():
    times = events(lambda t: jnp.where(t % 0.5 < 0.01, 1.0, 0.0), 20.0)
    expected = np.concatenate([[0.01], *(k * 0.5 + np.array([0, 0.01]) for k in range(1, 40))])
    np.testing.assert_allclose(times, expected, atol=1e-9)


@pytest.mark.parametrize("width", [0.02, 1e-3, 1e-5])
def test_a_smooth_pulse_gives_its_surroundings_and_its_peak(width):
    times = events(lambda t: jnp.exp(-(((t - 3.3) / width) ** 2)), 20.0)
    assert times.min() < 3.3 < times.max() and np.ptp(times) < 12 * width + 3 * 20 / 8191
    assert np.exp(-((np.abs(times - 3.3).min() / width) ** 2)) > 0.5


@pytest.mark.parametrize("frequency", [1e-3, 0.3, 1.3, 40.0, 700.0, 2573.0, 3000.0, 1e4, 1e5])
def test_a_harmonic_load_of_any_frequency_gives_no_times(frequency):
    assert not len(events(lambda t: 3.0 * jnp.cos(frequency * t - 0.3) + 1, 20.0))


@pytest.mark.parametrize(
    "load",
    [
        lambda t: jnp.exp(-0.3 * t) * jnp.sin(10 * t),
        lambda t: jnp.exp(-50 * t),
        lambda t: jnp.cos(t) + 0.01 * jnp.cos(300 * t),
        lambda t: jnp.sin(5 * t**2),
        lambda t: jnp.cos(50 * t) * jnp.cos(0.5 * t),
        lambda t: 0 * t + 3.0,
        lambda t: t,
    ],
)
def test_other_smooth_loads_give_no_times(load):
    assert not len(events(load, 20.0))


def test_a_pulse_of_a_4000th_of_the_duration_is_certain_to_be_found():
    """The time of the pulse is computed from other numbers, at random."""
    for start in np.random.default_rng(1).uniform(1.0, 19.0, 5):
        root = start**0.5

        def pulse(t, root=root):
            return jnp.maximum(0.0, 1 - ((t**0.5 - root) * (t**0.5 + root) * 2 * 4000 / 20) ** 2)

        times = events(pulse, 20.0)
        assert len(times) >= 2 and np.abs(times - start).max() < 20 / 4000


def test_a_scan_follows_what_the_load_reads():
    start = {"at": 3.0}

    def load(t):
        return jnp.where(t > start["at"], 1.0, 0.0)

    assert events(load, 10.0) == pytest.approx([3.0])
    start["at"] = 4.0
    assert events(load, 10.0) == pytest.approx([4.0])


def test_a_load_that_calls_the_host_is_scanned_one_time_after_the_other():
    """A scan at many times in one call, which a function on the host does not take."""

    def load(t):
        return jax.pure_callback(lambda t: np.where(t > 3.0, 1.0, 0.0), jax.ShapeDtypeStruct((), float), t)

    assert events(load, 10.0, intervals=251) == pytest.approx([3.0], abs=1e-9)


def test_kinks_that_a_load_declares_are_not_sought_and_those_of_its_other_part_are():
    ground = study.GroundMotion(np.array([0.0, 1.0, -2.0, 0.0]), 0.5)
    shaken = study.Problem(lambda u: u, 0.0, ground=ground, load=lambda t: jnp.where(t > 1.2, 1.0, 0.0))
    np.testing.assert_allclose(times_of(shaken.load, 4.0), [0.5, 1.0, 1.2, 1.5], atol=1e-9)
