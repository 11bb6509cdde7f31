"""Errors compared with a reference solution, checked on motions whose errors are known."""

import equinox as eqx
import jax
import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

import study
from study.analysis.comparison import against
from study.mechanics.state import Motion
from tests.references import cosine


def _harmonic(steps, stretch=1.0, decay=0.0):
    """Reference dataset of cos(2πt), and the problem of the motion exp(−decay t) cos(2πt/stretch)."""
    omega = 2 * np.pi / stretch
    problem = study.Problem(
        lambda u: (omega**2 + decay**2) * u, u0=1.0, v0=-decay, damping=2 * decay if decay else None
    )
    return cosine(steps), problem


def _observed(steps, periods, **motion):
    reference, problem = _harmonic(steps, **motion)
    dt, observers = against(reference, steps, longest=2 * steps)
    return study.run(problem, "rk4", dt=dt, steps=steps * periods, observe=observers)


def test_a_faithful_motion_has_no_error():
    ds = _observed(400, 10)
    assert ds.displacement_error < 1e-7
    assert abs(ds.period_elongation) < 1e-9 and abs(ds.phase_error) < 1e-8 and abs(ds.amplitude_decay) < 1e-9


def test_a_longer_period_is_measured():
    ds = _observed(400, 10, stretch=1.01)
    assert ds.period_elongation.item() == pytest.approx(0.01, abs=1e-8)
    # the tenth upward crossing is at 9.75 periods of the motion
    assert ds.phase_error.item() == pytest.approx(9.75 * 0.01, abs=1e-7)
    t = np.arange(1, 4001) / 400
    errors = np.abs(np.cos(2 * np.pi * t / 1.01) - np.cos(2 * np.pi * t))
    assert ds.displacement_error.item() == pytest.approx(errors.max(), abs=1e-6)
    assert ds.rms_displacement_error.item() == pytest.approx(np.sqrt(np.mean(errors**2)), abs=1e-6)


def test_a_decay_of_the_amplitude_is_measured():
    ds = _observed(400, 10, decay=0.05)
    assert ds.amplitude_decay.item() == pytest.approx(1 - np.exp(-0.05), abs=1e-7)


def test_after_one_crossing_there_is_a_phase_and_no_mean_period():
    ds = _observed(400, 1, stretch=1.01)
    assert ds.phase_error.item() == pytest.approx(0.75 * 0.01, abs=1e-8)
    assert np.isnan(ds.period_elongation)


def test_a_crossing_never_leaves_its_step():
    """The interpolated crossing lies within its step, even if the velocities at its ends are zero or negative."""
    reference, problem = _harmonic(50)
    _, (_, period, _) = against(reference, 50, longest=50)
    for before, after in ((0.0, 1.0), (1.0, 0.0), (-5.0, 1e-9), (0.0, 0.0)):
        now = np.array(0.3), np.array(after)
        earlier = tuple(map(np.array, (-0.2, before)))
        assert 6 <= period._crossing(problem, np.array(6.0), earlier, now) <= 7


@pytest.mark.slow
def test_interpolation_between_exact_steps_is_of_sixth_order():
    """With exact states the phase error is an interpolation error; halving the step size divides it by more than 50."""
    reference, problem = _harmonic(400)
    errors = []
    for steps in (25, 50):
        _, (_, period, amplitude) = against(reference, steps, longest=steps)
        states = [
            Motion(np.cos(2 * np.pi * t), -2 * np.pi * np.sin(2 * np.pi * t), np.array(0.0))
            for t in np.arange(3 * steps + 1) / steps
        ]
        observed: dict[str, jax.Array] = {}
        for observer in (period, amplitude):
            carried, update = observer.start(problem, states[0]), eqx.filter_jit(observer.update)
            for state in states[1:]:
                carried = update(carried, problem, state, 0.0, None)
            observed |= observer.result(carried, problem, states[-1])
        errors.append(abs(observed["phase_error"]))
        assert abs(observed["amplitude_decay"]) < 1e-12
    assert errors[0] < 1e-8 and errors[0] / errors[1] > 50


def test_a_motion_without_crossings_has_no_period():
    reference, _ = _harmonic(50)
    dt, observers = against(reference, 50, longest=50)
    ds = study.run(study.Problem(lambda u: 0.0 * u, u0=1.0), "rk4", dt=dt, steps=100, observe=observers)
    assert np.isnan(ds.period_elongation) and np.isnan(ds.amplitude_decay) and ds.status == 0


def test_errors_at_the_phases_of_equal_steps_need_equal_steps():
    dt, (trajectory_observer, *_) = against(_harmonic(50)[0], 50, longest=50)
    with pytest.raises(ValueError, match="rms_displacement_error, displacement_error needs steps of one size"):
        study.run("pendulum", "rk4", tolerance=1e-3, duration=1.0, dt=dt, observe=[trajectory_observer])


def test_phases_that_the_reference_lacks_are_refused():
    reference, _ = _harmonic(8)
    with pytest.raises(ValueError, match="'harmonic' has no phases of 7 steps per period; add 7 to references"):
        against(reference, 7, longest=8)


def test_the_reference_is_taken_at_the_times_of_the_run():
    """The comparison corrects the rounding error of the stored period, which would otherwise grow to a phase error."""
    reference, problem = _harmonic(400, stretch=1 + 1e-5)
    # the true period is longer than the stored one by 1e-5; if ``period_remainder`` states this, the run has no error
    errors = []
    for remainder in (0.0, 1e-5):
        dt, observers = against(reference.assign(period_remainder=remainder), 400, longest=400)
        ds = study.run(problem, "rk4", dt=dt, steps=4000, observe=observers)
        errors.append(ds.displacement_error.item())
    # the speed, and with it the error of the trajectory, has its last maximum at 9.75 periods
    assert errors[0] == pytest.approx(2 * np.pi * 9.75 * 1e-5, rel=1e-2)
    assert errors[1] < 1e-2 * errors[0]


def test_amplitudes_are_counted_from_the_equilibrium():
    """Amplitudes refer to the equilibrium, which for an asymmetric spring is not midway between the turning points."""
    phase = np.linspace(0, 1, 513)
    u = 0.9 + 0.4 * np.cos(2 * np.pi * phase) + 0.1 * np.cos(4 * np.pi * phase)
    v = -0.8 * np.pi * np.sin(2 * np.pi * phase) - 0.4 * np.pi * np.sin(4 * np.pi * phase)
    reference = xr.Dataset(
        {"u": ("t", u), "v": ("t", v), "period": 1.0, "period_remainder": 0.0},
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "lopsided"},
    )
    _, (*_, amplitude) = against(reference, 8, longest=8)
    # at the equilibrium the acceleration is zero
    rest = brentq(lambda x: 0.4 * np.cos(x) + 0.4 * np.cos(2 * x), 0, np.pi / 2)
    expected = 0.9 + 0.4 * np.cos(rest) + 0.1 * np.cos(2 * rest)
    assert float(amplitude.rest) == pytest.approx(expected, abs=1e-5)
    assert abs(expected - (u.max() + u.min()) / 2) > 0.04


def test_a_motion_that_has_come_to_rest_has_no_phase():
    reference, _ = _harmonic(50)
    dt, observers = against(reference, 50, longest=50)
    # 40 periods of a motion that soon comes to rest at u = 0.1, after which it no longer crosses zero
    problem = study.Problem(lambda u: (2 * np.pi) ** 2 * (u - 0.1), u0=1.0, damping=2.0)
    ds = study.run(problem, "rk4", dt=dt, steps=2000, observe=observers)
    assert np.isnan(ds.phase_error) and np.isnan(ds.period_elongation)
