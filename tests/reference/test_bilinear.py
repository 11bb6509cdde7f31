"""Exact motions of many bilinear oscillators, compared with the exact motion of each single oscillator."""

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate

from reference import bilinear, piecewise
from study.mechanics.ground import GroundMotion
from study.problem.inelastic import yielding_under_record

PERIODS, STRENGTHS = np.array([0.3, 0.3, 1.0, 2.0]), np.array([1e9, 1.5, 0.8, 0.3])
GROUNDS = [GroundMotion.kanai_tajimi(seed, duration=6.0) for seed in (1, 2, 1, 3)]


def _motions(places):
    stiffness = (2 * np.pi / PERIODS) ** 2
    samples = np.stack([ground.acceleration for ground in GROUNDS])
    return bilinear.motions(samples, 0.02, stiffness, 0.1 * np.sqrt(stiffness), STRENGTHS, 0.02, places)


@pytest.mark.slow
def test_many_oscillators_have_the_motion_of_one():
    """A peak between two samples, or a yield within an interval, that the solution of many oscillators misses."""
    t = np.linspace(0.0, 6.0, 12_001)[1:]
    for peak, at_samples, ground, period, strength in zip(*_motions(5), GROUNDS, PERIODS, STRENGTHS, strict=True):
        exact = piecewise.trajectory(yielding_under_record(ground, period, strength), t)
        spline = scipy.interpolate.CubicHermiteSpline(t, exact.u, exact.v)
        turns = spline.derivative().roots(extrapolate=False)
        largest = np.abs(np.append(exact.u, spline(turns))).max()  # the peak may be at the end
        assert peak == pytest.approx(largest, rel=1e-9)
        assert at_samples == pytest.approx(np.append(0.0, exact.u[39::40]), abs=1e-9 * largest)


@pytest.mark.slow
def test_peaks_do_not_depend_on_the_places_where_events_are_looked_for():
    np.testing.assert_allclose(_motions(5)[0], _motions(13)[0], rtol=1e-9)


def test_an_oscillator_thrown_by_a_pulse_has_its_closed_peak():
    # the peak under constant acceleration is the static displacement times 1 + d; d is the decay in half a period
    peak, _ = bilinear.motions(
        np.full((1, 101), -3.0), 0.02, np.array([16.0]), np.array([0.8]), np.array([1e9]), 0.02, 3
    )
    damped = np.exp(-0.1 * np.pi / np.sqrt(1 - 0.1**2))
    assert peak[0] == pytest.approx(3 / 16 * (1 + damped), rel=1e-12)


def test_the_time_of_an_event_is_found_where_round_off_exceeds_its_tolerance():
    # a yield point right after a turning point of a record that falls steeply
    level, end = np.array([-0.013047530328549328]), np.array([0.0011282289979270997])
    u, v, c, k, q0, q1 = start = np.array(
        [
            [-0.013047489678297275],
            [0.0],
            [0.3141592653589793],
            [9.869604401089358],
            [-0.37096184656033604],
            [-482.7100636187148],
        ]
    )
    motion = scipy.integrate.solve_ivp(
        lambda t, y: [y[1], (q0 + q1 * t - c * y[1] - k * (u + y[0]))[0]],
        (0, end[0]),
        [0.0, v[0]],
        events=lambda t, y: y[0] - (level - u)[0],
        rtol=1e-12,
        atol=1e-20,
    )
    assert bilinear.time_of(level, 0, end, start) == pytest.approx(motion.t_events[0], rel=1e-7)
