"""The predicted error of a step under a record."""

import numpy as np
import pytest
import scipy.signal

import study

PERIOD, DAMPING = 0.8, 0.04
FREQUENCY = 1 / PERIOD


@pytest.mark.parametrize("scheme", ["average_acceleration", "central_difference", "fox_goodwin"])
@pytest.mark.parametrize("record, ratio", [(0, 0.75), (4, 1), (8, 2.5), (12, 0.25)])
def test_the_error_is_that_of_a_run(scheme, record, ratio):
    """Against SciPy's exact motions, with records that begin at rest, within the shaking, or shake faster than both."""
    ground = study.GroundMotion.measured()[record]
    periods, dampings = np.array([0.3, 1.0, 2.0]), np.array([0.02, 0.4, 0.05])
    omegas = 2 * np.pi / periods

    def oscillator(omega, damping):
        return study.Problem(lambda u: omega**2 * u, 0.0, damping=2 * damping * omega, ground=ground)

    dt = ratio * ground.dt
    steps = int(ground.duration / dt)
    runs = study.run(oscillator, scheme, dt=dt, steps=steps, over={"omega": omegas, "damping": dampings})
    t = np.linspace(0.0, ground.duration, 8 * (len(ground.kinks) - 1) + 1)
    acceleration = np.interp(t, ground.kinks, ground.acceleration)
    for period, damping, omega, u in zip(periods, dampings, omegas, runs.u.values, strict=True):
        matrices = [[0, 1], [-(omega**2), -2 * damping * omega]], [[0], [-1]], [[1, 0]], [[0]]
        _, exact, _ = scipy.signal.lsim(matrices, acceleration, t)
        error = np.abs(u.ravel() - np.interp(runs.t.values, t, exact.ravel())).max() / np.abs(exact).max()
        predicted = study.record_error(ground, dt, period, damping, scheme)
        assert 0.9 < error / predicted.total < 1.001
        assert (predicted.load_error < 1e-9) == (1 / ratio % 1 == 0)


@pytest.mark.parametrize("scheme, beta", [("average_acceleration", 0.25), ("central_difference", 0.0)])
def test_the_error_under_a_record_of_three_samples(scheme, beta):
    """Against Newmark's formulas: a grid of frequencies that is as coarse as the record is short."""
    ground, dt, omega = study.GroundMotion(np.array([1.0, 0.5, -0.3]), 0.02), 0.01, 2 * np.pi / 0.3
    t = np.linspace(0, ground.duration, 401)
    matrices = [[0, 1], [-(omega**2), 0]], [[0], [-1]], [[1, 0]], [[0]]
    _, exact, _ = scipy.signal.lsim(matrices, np.interp(t, ground.kinks, ground.acceleration), t)
    u, v, errors = 0.0, 0.0, []
    loads = np.append(-np.interp(dt * np.arange(4), ground.kinks, ground.acceleration), 0.0)
    a = loads[0]
    for n, load in enumerate(loads[1:], start=1):
        u += dt * v + dt**2 * (0.5 - beta) * a
        after = (load - omega**2 * u) / (1 + beta * (omega * dt) ** 2)
        u, v, a = u + beta * dt**2 * after, v + dt / 2 * (a + after), after
        errors.append(abs(u - exact[100 * n]))
    predicted = study.record_error(ground, dt, 0.3, 1e-6, scheme).total
    assert 0.8 < max(errors) / np.abs(exact).max() / predicted < 1.01


def test_the_error_falls_with_the_square_of_tiny_steps():
    """Round-off that the straight lines between close values of the record amplify."""
    ground = study.GroundMotion(np.random.default_rng(3).standard_normal(5), 0.02)
    coarse, fine, tiny = (study.record_error(ground, ground.dt / parts, 1.0) for parts in (10, 100, 20_000))
    assert fine.total == pytest.approx(coarse.total / 100, rel=0.05)
    assert max(tiny) < 1e-6 and tiny.load_error < 1e-8


def test_the_error_of_the_period_in_noise_about_the_frequency():
    dt, damping, rng = 0.02, 0.08, np.random.default_rng(1)
    frequency = np.fft.rfftfreq(20_000, dt)
    band = (frequency > FREQUENCY / 2) & (frequency < 2 * FREQUENCY)
    noise = study.GroundMotion(np.fft.irfft(band * np.fft.rfft(rng.standard_normal(20_000))), dt)
    expected = (2 * np.pi * FREQUENCY * dt) ** 2 / 12 / (np.sqrt(2) * damping)
    for scheme, share in (("average_acceleration", 1.0), ("central_difference", 0.5)):
        error = study.record_error(noise, dt, PERIOD, damping, scheme)
        assert error.period_error == pytest.approx(share * expected, rel=0.3)
        assert error.load_error == pytest.approx(0, abs=1e-9)


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
        ({"scheme": "rk4"}, "the error of 'Runge-Kutta.*' under a record is not known without a run"),
        ({"scheme": "implicit_midpoint"}, "it is for Newmark's methods with gamma = 0.5"),
        ({"dt": 0.0}, "dt must be a positive number, not 0.0"),
        ({"dt": "10 ms"}, "dt must be a positive number, not '10 ms'"),
        ({"damping": -1}, "damping must be a positive number"),
        ({"damping": 5}, "damping must be a fraction of the critical damping below 1, such as 0.05, not 5"),
        ({"dt": 40.0}, "dt must be less than the duration of 'el_centro_1940_ns', 31.18 s, not 40.0"),
        ({"period": []}, "period must be a positive number or an array of them"),
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
