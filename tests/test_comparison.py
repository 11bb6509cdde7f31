"""The observers that hold a run against the truth, checked on motions whose errors are known."""

import numpy as np
import pytest
import xarray as xr

import study
from paper.orders import observed_order
from study.comparison import against


def _harmonic(steps, stretch=1.0, decay=0.0):
    """Reference of cos(2πt) as the pipeline writes it, and a problem that moves with another period and damping."""
    phase = np.linspace(0, 1, 64 * steps + 1)
    reference = xr.Dataset(
        {
            "u": ("t", np.cos(2 * np.pi * phase)),
            "v": ("t", -2 * np.pi * np.sin(2 * np.pi * phase)),
            "period": 1.0,
            "period_remainder": 0.0,
        },
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "harmonic"},
    )
    omega = 2 * np.pi / stretch
    problem = study.Problem(
        lambda u: (omega**2 + decay**2) * u, u0=1.0, v0=-decay, damping=2 * decay if decay else None
    )
    return reference, problem


def _observed(steps, periods, **motion):
    reference, problem = _harmonic(steps, **motion)
    dt, observers = against(reference, steps, longest=2 * steps)
    return study.run(problem, "rk4", dt=dt, steps=steps * periods, observe=observers)


def test_a_faithful_motion_has_no_error():
    ds = _observed(400, 10)
    assert ds.max_trajectory_error < 1e-7
    assert abs(ds.period_elongation) < 1e-9 and abs(ds.phase_error) < 1e-8 and abs(ds.amplitude_decay) < 1e-9


def test_a_longer_period_is_measured():
    ds = _observed(400, 10, stretch=1.01)
    assert ds.period_elongation.item() == pytest.approx(0.01, abs=1e-8)
    # the tenth upward crossing comes at 9.75 of the longer periods
    assert ds.phase_error.item() == pytest.approx(9.75 * 0.01, abs=1e-7)
    t = np.arange(1, 4001) / 400
    errors = np.abs(np.cos(2 * np.pi * t / 1.01) - np.cos(2 * np.pi * t))
    assert ds.max_trajectory_error.item() == pytest.approx(errors.max(), abs=1e-6)
    assert ds.rms_trajectory_error.item() == pytest.approx(np.sqrt(np.mean(errors**2)), abs=1e-6)


def test_a_decay_of_the_amplitude_is_measured():
    ds = _observed(400, 10, decay=0.05)
    assert ds.amplitude_decay.item() == pytest.approx(1 - np.exp(-0.05), abs=1e-7)


def test_a_motion_without_crossings_has_no_period():
    reference, _ = _harmonic(50)
    dt, observers = against(reference, 50, longest=50)
    ds = study.run(study.Problem(lambda u: 0.0 * u, u0=1.0), "rk4", dt=dt, steps=100, observe=observers)
    assert np.isnan(ds.period_elongation) and np.isnan(ds.amplitude_decay) and ds.status == 0


def test_phases_that_the_reference_lacks_are_refused():
    reference, _ = _harmonic(8)
    with pytest.raises(ValueError, match="'harmonic' has no phases of 7 steps per period; add 7 to references"):
        against(reference, 7, longest=8)


def test_compensated_sums_lower_the_floor_and_nothing_else():
    period, steps = 0.151532834447260357127078726219, 200_000
    ends = {
        name: abs(study.run("hardening", scheme, dt=period / 4 / steps, steps=steps, every=steps).u.values[-1])
        for name, scheme in {"plain": "rk4", "compensated": study.Compensated(study.schemes["rk4"])}.items()
    }
    assert ends["compensated"] < 2e-15 < ends["plain"]
    coarse = [
        study.run("softening", scheme, dt=0.05, steps=100).u.values
        for scheme in ("average_acceleration", study.Compensated(study.schemes["average_acceleration"]))
    ]
    np.testing.assert_allclose(*coarse, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 5])
def test_a_power_law_is_found(order):
    steps = np.array([8, 16, 32, 64, 128, 256])
    error = xr.DataArray(
        0.3 * (steps / 8.0) ** -order, {"steps_per_period": steps}, attrs={"units": "1"}, name="max_trajectory_error"
    )
    assert observed_order(error) == pytest.approx(order, abs=1e-9)


def test_no_order_is_made_of_what_is_no_power_law():
    steps = np.array([8, 16, 32, 64, 128, 256])
    crossing = xr.DataArray(
        1e-3 * np.array([8, 4, 1, 0.01, -0.2, -0.3]),
        {"steps_per_period": steps},
        attrs={"units": "1"},
        name="phase_error",
    )
    assert np.isnan(observed_order(crossing))
    floor = xr.DataArray(np.full(6, 1e-13), {"steps_per_period": steps}, attrs={"units": "1"}, name="phase_error")
    assert np.isnan(observed_order(floor))


def test_times_of_the_truth_are_those_of_the_run():
    """The lag of a rounded step size is known: over a million steps it would otherwise look like an error."""
    reference, problem = _harmonic(400, stretch=1 + 1e-5)
    # the motion of a period that the stored one lacks by 1e-5 has no error when the remainder is known
    errors = []
    for remainder in (0.0, 1e-5):
        dt, observers = against(reference.assign(period_remainder=remainder), 400, longest=400)
        ds = study.run(problem, "rk4", dt=dt, steps=4000, observe=observers)
        errors.append(ds.max_trajectory_error.item())
    # the last time that the motion is fastest is at 9.75 periods
    assert errors[0] == pytest.approx(2 * np.pi * 9.75 * 1e-5, rel=1e-2)
    assert errors[1] < 1e-2 * errors[0]


def test_amplitudes_are_counted_from_the_equilibrium():
    """In the double well that is u = 1, not the middle between the turning points."""
    phase = np.linspace(0, 1, 513)
    u = 1 + 0.4 * np.cos(2 * np.pi * phase) + 0.1 * np.cos(4 * np.pi * phase) - 0.1
    reference = xr.Dataset(
        {"u": ("t", u), "v": ("t", np.gradient(u, phase)), "period": 1.0, "period_remainder": 0.0},
        coords={"phase": ("t", phase)},
        attrs={"problem": "lopsided"},
    )
    _, (*_, amplitude) = against(reference, 8, longest=8)
    fastest = u[np.argmax(np.abs(np.gradient(u, phase)))]
    assert float(amplitude.rest) == fastest != (u.max() + u.min()) / 2


def test_a_motion_that_has_come_to_rest_elsewhere_has_no_phase():
    reference, _ = _harmonic(50)
    dt, observers = against(reference, 50, longest=50)
    # 40 periods of a motion that is damped out after a few and drifts away from the level
    problem = study.Problem(lambda u: (2 * np.pi) ** 2 * (u - 0.1), u0=1.0, damping=2.0)
    ds = study.run(problem, "rk4", dt=dt, steps=2000, observe=observers)
    assert np.isnan(ds.phase_error) and np.isnan(ds.period_elongation)
