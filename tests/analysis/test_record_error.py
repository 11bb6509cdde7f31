"""The predicted error of a step under a record."""

import numpy as np
import pytest

import study

PERIOD, DAMPING = 0.8, 0.04
FREQUENCY = 1 / PERIOD


def test_a_step_that_divides_the_spacing_has_the_error_of_the_period_in_white_noise():
    # average acceleration maps the frequency Ω to 2/Δt tan(ΩΔt/2) in the response of the oscillator
    omega, dt = 2 * np.pi * FREQUENCY, 0.01
    w = np.linspace(0, 8 * omega, 400_001)

    def response(at):
        return 1 / (omega**2 - at**2 + 2j * DAMPING * omega * at)

    off = np.abs(response(2 / dt * np.tan(w * dt / 2)) - response(w))
    expected = np.sqrt(np.sum(off**2) / np.sum(np.abs(response(w)) ** 2))
    white = study.GroundMotion(np.eye(1, 4001, 1)[0], 2 * dt)
    error = study.record_error(white, dt, PERIOD, DAMPING)
    assert error.load_error == pytest.approx(0, abs=1e-12)
    assert error.total == pytest.approx(expected, rel=0.02)
    assert error.total == pytest.approx((omega * dt) ** 2 / 12 / (np.sqrt(2) * DAMPING), rel=0.05)
    central = study.record_error(white, dt, PERIOD, DAMPING, "central_difference")
    assert error.period_error == pytest.approx(2 * central.period_error, rel=0.05)


@pytest.mark.parametrize("scheme, most", [("average_acceleration", 1.4), ("central_difference", 2.6)])
def test_the_error_is_that_of_runs_at_any_damping(scheme, most):
    """Against runs with a 64th of the step; a formula for white noise would be up to 12 times too small."""
    ground, dt = study.GroundMotion.el_centro(), 0.02
    steps = int(ground.duration / dt)
    omega = 2 * np.pi / PERIOD
    for damping in (0.05, 0.4):
        oscillator = study.Problem(lambda u: omega**2 * u, 0.0, damping=2 * damping * omega, ground=ground)
        exact = study.run(oscillator, "average_acceleration", dt=dt / 64, steps=64 * steps, every=64).u
        error = np.abs(study.run(oscillator, scheme, dt=dt, steps=steps).u - exact).max() / np.abs(exact).max()
        predicted = study.record_error(ground, dt, PERIOD, damping, scheme).total
        assert 0.5 < error / predicted < most


def test_power_that_the_steps_mistake_for_that_of_the_oscillator_is_its_error():
    # at the steps both harmonics are equal; straight lines between the steps keep sinc² of the first
    dt, spacing, ratio = 0.05, 0.002, 0.07
    t = spacing * np.arange(100_001)
    alias = np.cos(2 * np.pi * (1 / dt - FREQUENCY) * t)
    ground = study.GroundMotion(np.cos(2 * np.pi * FREQUENCY * t) + ratio * alias, spacing)
    coarse = study.record_error(ground, dt * (1 + 1e-9), np.array([PERIOD, 2 * PERIOD]), DAMPING)
    seen = (1 + ratio) * np.sinc(FREQUENCY * dt) ** 2
    assert coarse.load_error[0] == pytest.approx(seen - 1, rel=0.01)


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"scheme": "rk4"}, "the error of 'Runge-Kutta.*' is not known without a run"),
        ({"dt": 0.0}, "dt must be a positive number, not 0.0"),
        ({"dt": "10 ms"}, "dt must be a positive number, not '10 ms'"),
        ({"damping": -1}, "damping must be a positive number"),
        ({"period": [0.5, 0.0]}, "period must be a positive number or an array of them"),
        ({"ground": study.GroundMotion(np.zeros(100), 0.01, title="silence")}, "'silence' is zero at all times"),
        ({"scheme": "central_difference", "dt": 0.32}, "dt must be below 0.3183 s, the stability limit"),
    ],
)
def test_what_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        study.record_error(**{"ground": study.GroundMotion.el_centro(), "dt": 0.01, "period": 1.0} | arguments)


@pytest.mark.parametrize("ground", ["record.AT2", np.ones(100)])
def test_a_record_is_a_ground_motion(ground):
    with pytest.raises(TypeError, match="ground must be a record, such as study.GroundMotion.read"):
        study.record_error(ground, 0.01, 1.0)
