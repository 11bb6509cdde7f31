"""Runs with step size control: their steps, their order, their ensembles, and their failures."""

import re

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.marching import adaptive_run
from study.scheme.named import schemes


def load(t):
    return 0.5 * jnp.cos(1.3 * t)


DRIVEN = study.Problem(lambda u: u + u**3, u0=1.0, v0=0.3, damping=0.1, load=load)


@pytest.fixture(scope="module")
def end():
    return study.run(DRIVEN, "gauss4", dt=1 / 1000, steps=4000).u.values[-1]


def order(scheme, end, sizes):
    """Observed order of the displacement after four seconds, with step sizes in the given proportions."""
    errors = []
    for n in (80, 160):
        steps = study.Prescribed(np.asarray(sizes) / np.mean(sizes) * 4 / n)
        errors.append(abs(study.run(DRIVEN, scheme, controller=steps, duration=4.0).u.values[-1] - end))
    return np.log2(errors[0] / errors[1])


RANDOM = np.random.default_rng(1996).uniform(0.3, 1.7, 40)


@pytest.mark.parametrize("sizes", [(1, 2), RANDOM], ids=["alternating", "random"])
@pytest.mark.parametrize("name", ["hht_alpha", "wbz_alpha", "generalized_alpha"])
def test_an_alpha_method_keeps_its_order_by_either_correction(name, sizes, end):
    for correction in ("difference", "balance"):
        assert order(study.UnequalSteps(scheme=schemes[name], correction=correction), end, sizes) == pytest.approx(
            2, abs=0.1
        )
    if sizes is not RANDOM:
        assert order(study.UnequalSteps(scheme=schemes[name], correction="none"), end, sizes) < 1.85


@pytest.mark.parametrize(
    "name", ["average_acceleration", "central_difference", "wilson_theta", "chung_lee", "bathe", "nystrom4", "yoshida4"]
)
def test_a_scheme_without_a_shifted_acceleration_keeps_its_order(name, end):
    assert order(name, end, (1, 2)) == pytest.approx(schemes[name].order_with_damping, abs=0.15)


@pytest.mark.slow
def test_equal_steps_are_those_of_a_run_with_equal_steps():
    for name in ("hht_alpha", "rk4"):
        equal = study.run(DRIVEN, name, dt=0.05, steps=60)
        prescribed = study.run(DRIVEN, name, controller=study.Prescribed([0.05]), duration=3.0)
        np.testing.assert_allclose(prescribed.t, equal.t, atol=1e-13)
        np.testing.assert_allclose(prescribed.u, equal.u, atol=1e-11)


def test_given_sizes_are_kept_up_to_a_stated_time():
    sizes = [0.1, 0.02, 0.3, 0.05]
    ds = study.run(DRIVEN, "average_acceleration", controller=study.Prescribed(sizes), duration=0.8, times=[0.44])
    np.testing.assert_allclose(ds.step_size[1:], [0.1, 0.02, 0.3, 0.02, 0.1, 0.02, 0.24], rtol=1e-12)


@pytest.mark.slow
def test_the_error_falls_with_the_tolerance(end):
    for name in ("average_acceleration", "rk4", "bathe"):
        runs = [study.run(DRIVEN, name, tolerance=tolerance, duration=4.0) for tolerance in (1e-3, 1e-5)]
        errors = [abs(ds.u.values[-1] - end) for ds in runs]
        assert errors[1] < errors[0] / 5 < 0.02 and runs[0].steps < runs[1].steps
        for ds in runs:
            assert ds.t[-1] == 4 and ds.t.size == ds.steps + 1
            np.testing.assert_allclose(ds.step_size[1:], np.diff(ds.t), atol=1e-14)
            assert ds.rejected_by_estimate.sum() == ds.steps_rejected_by_estimate
            assert (ds.estimate[1:] <= float(ds.attrs["tolerance"])).all()


@pytest.mark.slow
def test_steps_end_on_stated_times_and_on_the_samples_of_a_record():
    ds = study.run(DRIVEN, "average_acceleration", tolerance=1e-2, duration=4.0, times=[0.1, np.pi])
    assert np.isin([0.1, np.pi, 4.0], ds.t).all()
    record = study.GroundMotion.kanai_tajimi(3, dt=0.05, duration=4.0)
    frame = study.Problem(stiffness=30.0, damping=0.5, u0=0.0, ground=record)
    ds = study.run(frame, "average_acceleration", tolerance=1e-3, duration=3.0)
    assert ds.status == 0 and np.isin(record.kinks[1:60], ds.t).all() and 60 < ds.steps < 600


#: Circular frequency and damping ratio of an oscillator at rest that a pulse of one newton second sets in motion.
OMEGA, RATIO = 2 * np.pi, 0.02


def peak_after(pulse):
    """Largest displacement after a pulse near t = 8, by Duhamel's integral."""
    damped = OMEGA * np.sqrt(1 - RATIO**2)
    tau, t = np.linspace(7.9, 8.1, 100_001), np.linspace(8.1, 9.1, 5001)
    grown = np.asarray(pulse(jnp.asarray(tau))) * np.exp(RATIO * OMEGA * tau)
    c, s = (np.trapezoid(grown * f(damped * tau), tau) for f in (np.cos, np.sin))
    return np.abs(np.exp(-RATIO * OMEGA * t) / damped * (np.sin(damped * t) * c - np.cos(damped * t) * s)).max()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "rk4"])
@pytest.mark.parametrize(
    "pulse",
    [
        lambda t: jnp.where((t >= 8) & (t < 8.02), 50.0, 0.0),
        lambda t: jnp.where((t > 8) & (t < 8.02), 25 * jnp.pi * jnp.sin(jnp.pi * (t - 8) / 0.02), 0.0),
        lambda t: 50 * jnp.exp(-(((t - 8) / 0.01) ** 2)),
    ],
    ids=["rectangle", "half-sine", "smooth"],
)
def test_no_step_passes_over_a_pulse(scheme, pulse):
    struck = study.Problem(lambda u: OMEGA**2 * u, 0.0, damping=2 * RATIO * OMEGA, load=pulse)
    ds = study.run(struck, scheme, tolerance=1e-6, duration=20.0)
    assert abs(ds.u).max() == pytest.approx(peak_after(pulse), rel=0.02)


def test_no_step_of_a_lane_passes_over_its_own_pulse():
    def struck(at):
        return study.Problem(
            lambda u: OMEGA**2 * u,
            0.0,
            damping=2 * RATIO * OMEGA,
            load=lambda t: jnp.where((t >= at) & (t < at + 0.02), 50.0, 0.0),
        )

    ds = study.run(struck, "rk4", over={"at": [8.0, 3.1, 11.7]}, tolerance=1e-6, duration=20.0, observe=["peak"])
    wanted = peak_after(lambda t: jnp.where((t >= 8) & (t < 8.02), 50.0, 0.0))
    np.testing.assert_allclose(ds.peak, wanted, rtol=0.02)


@pytest.mark.slow
def test_stated_times_are_joined_with_those_of_the_load():
    step = study.Problem(lambda u: u, 0.0, load=lambda t: jnp.where(t > 2.5, 1.0, 0.0))
    ds = study.run(step, "average_acceleration", tolerance=1e-3, duration=4.0, times=[1.25])
    assert 1.25 in ds.t
    beside = ds.t.values[np.abs(ds.t.values - 2.5) < 1e-8]
    assert len(beside) == 2 and beside[0] < 2.5 < beside[1]


@pytest.mark.slow
def test_the_forces_of_a_trial_run_stand_apart():
    """From rest, a trial run measures the largest velocity: 200 steps of Bathe's method, each with two substeps."""

    def counted(v0):
        problem = study.Problem(lambda u: u + u**3, u0=1.0, v0=v0)
        return study.run(problem, "rk4", tolerance=[1e-3, 1e-5], duration=10.0, observe=["effort"])

    rest, moving = counted(0.0), counted(0.02)
    assert (rest.trial_run_force_evaluations > 400).all() and (moving.trial_run_force_evaluations == 0).all()
    np.testing.assert_allclose(rest.force_evaluations, moving.force_evaluations, rtol=0.1)
    assert "trial_run_force_evaluations" not in study.run(DRIVEN, "rk4", tolerance=1e-3, duration=1.0)


def test_a_lane_is_a_run():
    tolerances = [1e-4, 1e-3, 1e-2]
    lanes = study.run(DRIVEN, "hht_alpha", tolerance=tolerances, duration=4.0)
    several = study.run(DRIVEN, "hht_alpha", tolerance=tolerances, duration=4.0, observe=["peak"])
    for lane, tolerance in enumerate(tolerances):
        run = study.run(DRIVEN, "hht_alpha", tolerance=tolerance, duration=4.0, observe=["trajectory", "peak"])
        motion = lanes.isel(lane=lane).dropna("sample", subset=["u"])
        assert motion.steps == run.steps == several.steps[lane] == motion.sizes["sample"] - 1
        np.testing.assert_allclose(motion.u, run.u, atol=1e-6)
        assert several.peak[lane] == pytest.approx(run.peak.item(), abs=1e-7)


def test_a_family():
    def spring(hardening):
        return study.Problem(lambda u: u + hardening * u**3, u0=1.0)

    wanted = {"tolerance": 1e-4, "duration": 5.0}
    ds = study.run(spring, "average_acceleration", over={"hardening": [0.0, 1.0, 9.0]}, **wanted)
    last = study.run(spring(9.0), "average_acceleration", **wanted)
    assert ds.steps[2] == last.steps > ds.steps[0]
    assert ds.u.dropna("sample", how="all")[2, -1] == pytest.approx(last.u[-1].item(), abs=1e-6)
    assert ds.hardening.values.tolist() == [0, 1, 9]


def test_many_samples_and_several_unknowns(monkeypatch):
    """A run stores the steps of several calls; the motion agrees with the closed form."""
    monkeypatch.setattr(adaptive_run, "MOST_ROOM", 2**11)
    problem = study.Problem(stiffness=np.array([[2.0, -1.0], [-1.0, 2.0]]), u0=[1.0, 0.0])
    ds = study.run(problem, "average_acceleration", tolerance=1e-8, duration=30.0)
    assert ds.steps > 4 * 2**11 and ds.u.dims == ("t", "component") and (np.diff(ds.t) > 0).all()
    t = ds.t.values
    exact = (np.cos(t) + np.cos(np.sqrt(3) * t)) / 2
    assert abs(ds.u.values[:, 0] - exact).max() < 1e-4


def test_a_history_is_committed_by_accepted_steps_alone():
    yielding = study.problems["yielding"]
    fine = study.run(yielding, "average_acceleration", dt=1e-3, steps=5000, observe=["trajectory"])
    ds = study.run(yielding, "average_acceleration", tolerance=1e-5, duration=5.0, observe=["trajectory", "peak"])
    assert ds.steps_rejected_by_estimate > 0
    largest = abs(fine.u.values).max()
    assert abs(np.interp(fine.t, ds.t, np.ravel(ds.u)) - np.ravel(fine.u)).max() < 0.02 * largest


def test_a_motion_that_leaves_all_bounds_keeps_what_was_computed():
    away = study.Problem(lambda u: -(u**3), u0=1.0)
    with pytest.warns(study.RunFailedWarning, match="the displacement left its bound"):
        ds = study.run(away, "central_difference", tolerance=1e-4, duration=10.0)
    assert ds.status == 3 and 1.8 < ds.failed_at_time < 1.9 and np.isfinite(ds.u).all() and ds.t.size > 100
    assert ds.failed_at_step == ds.t.size == ds.steps + 1


@pytest.mark.slow
def test_a_step_that_shrinks_to_nothing_is_a_status():
    jump = study.Problem(lambda u: jnp.where(u > 0.5, 1.0, -1e6), u0=1.0)
    with pytest.warns(study.RunFailedWarning, match="shrank to nothing"):
        ds = study.run(
            jump, "central_difference", tolerance=1e-12, duration=3.0, estimator="step_doubling", steps=10**5
        )
    assert int(ds.status) == 4 and ds.failed_at_time == pytest.approx(1.0, abs=0.01) and (ds.u[:-1] > 0.49).all()
    with pytest.warns(study.RunFailedWarning, match="reached the largest number of steps"):
        ds = study.run(DRIVEN, "rk4", tolerance=1e-8, duration=10.0, steps=7)
    assert int(ds.status) == 5 and ds.steps == 7
    with pytest.raises(RuntimeError, match="reached the largest number of steps"):
        study.run(DRIVEN, "rk4", tolerance=1e-8, duration=10.0, steps=7, on_failure="raise")


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"tolerance": 0.0}, "tolerance must be greater than round-off, 2.2e-16, and finite, not 0.0"),
        ({"tolerance": 1e-17}, "greater than round-off"),
        ({"duration": None}, "duration must be a time greater than zero, not None"),
        ({"times": [9.0]}, r"times must lie between zero and the duration, 4 s, not \[9.0\]"),
        ({"times": [np.nan]}, r"times must lie between zero and the duration, 4 s, not \[nan\]"),
        ({"dt": -1.0}, "dt must be finite and greater than zero"),
        ({"scheme": "houbolt"}, "'Houbolt' needs steps of one size"),
        ({"observe": ["oscillations"]}, "crossings.* needs steps of one size"),
        ({"controller": "pid"}, "no controller 'pid'; did you mean 'pi'"),
        ({"estimator": "richardson"}, "no estimator 'richardson'"),
        ({"every": 5}, "every and samples belong to a run with equal steps"),
    ],
)
def test_a_wrong_argument_gets_a_sentence(arguments, message):
    wanted = {"scheme": "average_acceleration", "tolerance": 1e-3, "duration": 4.0} | arguments
    with pytest.raises((ValueError, KeyError, TypeError), match=message):
        study.run(DRIVEN, wanted.pop("scheme"), **wanted)


def test_equal_steps_need_their_size_and_number():
    with pytest.raises(TypeError, match="needs dt and steps, or a tolerance and a duration"):
        study.run(DRIVEN, "rk4", dt=0.1)
    with pytest.raises(TypeError, match="belong to a run with a tolerance"):
        study.run(DRIVEN, "rk4", dt=0.1, steps=5, duration=3.0)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "rk4"])
@pytest.mark.parametrize(
    "load, right",
    [
        (lambda t: jnp.where((t > 8) & (t < 8.02), 50.0, 0.0), 0.154),
        (lambda t: jnp.where((t > 4) & (t < 8), 1.0, 0.0), 0.0491),
        (lambda t: jnp.where(t > 3, 2000 * jnp.exp(-(t - 3) / 0.01), 0.0), 3.083),
    ],
    ids=["short", "long", "blast"],
)
def test_a_load_that_is_zero_at_its_jumps_is_not_passed_over(scheme, load, right):
    """Peaks of an oscillator of 1 s with 2 % damping, by DOP853 on each side of the jumps."""
    omega = 2 * np.pi
    struck = study.Problem(stiffness=omega**2, u0=0.0, damping=0.04 * omega, load=load)
    ds = study.run(struck, scheme, tolerance=1e-5, duration=10.0)
    assert np.abs(ds.u).max() == pytest.approx(right, rel=0.02)


def test_the_default_bound_follows_a_pulse_between_its_samples():
    load = study.Problem(lambda u: 39.5 * u, 0.0, load=lambda t: jnp.where((t > 3.30025) & (t < 3.30065), 1e3, 0.0))
    ds = study.run(load, "average_acceleration", dt=1e-4, steps=40000, observe="peak", on_failure="raise")
    # an impulse of 0.4
    assert ds.peak == pytest.approx(0.4 / np.sqrt(39.5), rel=1e-3)


def falling(energy: bool) -> study.Problem:
    """A mass that falls by 2 m on a floor of stiffness 10⁵, with or without its potential."""

    def force(u):
        return 9.81 + jnp.where(u < 0, 1e5 * u, 0.0)

    def potential(u):
        return 9.81 * u + jnp.where(u < 0, 0.5e5 * u**2, 0.0)

    return study.Problem(force, u0=2.0, potential=potential if energy else None)


@pytest.mark.slow
@pytest.mark.parametrize("energy", [True, False])
def test_a_run_that_loses_much_of_a_constant_energy_gives_a_warning(energy):
    """The warning states the part of g h = 19.62 that the last state lacks; a lane and a tight tolerance lack less."""
    problem, options = falling(energy), {"duration": 5.0, "estimator": "step_doubling"}
    with pytest.warns(RuntimeWarning, match="Runge-Kutta' has lost energy") as caught:
        ds = study.run(problem, "rk4", tolerance=1e-2, **options)
    u, v = float(ds.u[-1]), float(ds.v[-1])
    lost = 1 - (v**2 / 2 + 9.81 * u + 0.5e5 * min(u, 0.0) ** 2) / (9.81 * 2)
    (stated,) = map(float, re.findall(r"([\d.]+)\xa0% of the largest", str(caught[0].message)))
    assert stated == pytest.approx(100 * lost, rel=0.05)
    study.run(problem, "rk4", tolerance=1e-5, **options)
    with pytest.warns(RuntimeWarning, match="in lane 1,"):
        study.run(problem, "rk4", tolerance=[1e-5, 1e-2], observe=[], **options)


@pytest.mark.slow
def test_a_run_within_a_contact_or_at_rest_has_lost_no_energy():
    """The force of the last problem is too stiff for the points at which its work is integrated."""
    study.run(study.Problem(jnp.sin, u0=0.0), "rk4", tolerance=1e-2, duration=1.0)
    stiff = study.Problem(lambda u: 9.81 + jnp.where(u < 0, 1e8 * u, 0.0), u0=2.0)
    ds = study.run(stiff, "generalized_alpha", tolerance=1e-4, duration=0.6386)
    assert float(ds.u[-1]) < 0


@pytest.mark.slow
def test_a_pulse_that_begins_just_after_the_start_is_seen_whole():
    """The impulse of 0.1 on a mass at rest gives the velocity 0.1, also if the load is zero at t = 0 itself."""
    problem = study.Problem(lambda u: u, u0=0.0, load=lambda t: jnp.where((t > 0) & (t < 1e-6), 1e5, 0.0))
    for scheme in ("average_acceleration", "central_difference"):
        ds = study.run(problem, scheme, tolerance=1e-4, duration=5.0)
        assert float(np.abs(ds.u).max()) == pytest.approx(0.1, rel=0.01)
