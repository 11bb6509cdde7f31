"""The compiled march: what it observes, how it fails, and that ensembles are many single runs."""

import jax
import numpy as np
import pytest

import study
from study.march import march_one


def test_reductions_agree_with_the_trajectory(scheme_name):
    problem = study.problems["hardening"]
    ds = study.run(
        "hardening",
        scheme_name,
        dt=0.15 / 20,
        steps=300,
        observe=["trajectory", "energy_error", "max_energy_error", "energy_drift"],
    )
    energy = 0.5 * ds.v**2 + 50 * ds.u**2 + 250 * ds.u**4
    error = 100 * (energy - energy[0]) / energy[0]
    np.testing.assert_allclose(ds.energy_error, error, atol=1e-10)
    assert ds.max_energy_error.item() == pytest.approx(np.abs(error).max().item(), rel=1e-10)
    assert ds.energy_drift.item() == pytest.approx(error[-1].item(), abs=1e-10)
    assert ds.u[0] == problem.u0 and ds.status == 0 and ds.failed_at_step == -1


def test_storing_every_tenth_step_takes_them_out_of_the_whole(scheme_name):
    whole, tenth = (study.run("softening", scheme_name, dt=0.05, steps=200, every=k) for k in (1, 10))
    np.testing.assert_array_equal(tenth.u, whole.u[::10])
    np.testing.assert_array_equal(tenth.t, whole.t[::10])


def test_newton_iterations_are_counted():
    ds = study.run("hardening", "average_acceleration", dt=0.15 / 20, steps=100, observe=["newton_iterations"])
    assert 100 < ds.newton_iterations.item() < 600
    assert 2 <= ds.max_newton_iterations.item() <= 10


def test_a_lane_of_an_ensemble_is_a_single_run(scheme_name):
    u0, dt = np.linspace(0.5, 2.0, 7), np.linspace(0.001, 0.02, 7)
    observe = ["trajectory", "max_energy_error", "newton_iterations"]
    lanes = study.run("hardening", scheme_name, dt=dt, u0=u0, steps=40, observe=observe)
    for lane in range(7):
        one = study.run("hardening", scheme_name, dt=dt[lane], u0=u0[lane], steps=40, observe=observe)
        for name in one.data_vars:
            np.testing.assert_allclose(lanes[name][lane], one[name], rtol=1e-9, atol=1e-9, err_msg=name)
    assert lanes.t.dims == ("lane", "sample")


def test_a_failed_lane_leaves_the_others_alone():
    dt = [0.001, 0.9, 0.002]
    lanes = study.run("hardening", "central_difference", dt=dt, steps=100, observe=["trajectory", "max_energy_error"])
    assert lanes.status.values.tolist() == [0, 2, 0]
    assert np.isnan(lanes.max_energy_error[1]) and np.isfinite(lanes.max_energy_error[[0, 2]]).all()
    failed = int(lanes.failed_at_step[1])
    assert np.isfinite(lanes.u[1, :failed]).all() and np.isnan(lanes.u[1, failed:]).all()
    assert np.isfinite(lanes.u[[0, 2]]).all()


def test_blow_up_is_recorded_with_its_step():
    ds = study.run("double_well", "central_difference", dt=2.5, steps=1000)
    step = ds.failed_at_step.item()
    assert ds.status.attrs["flag_meanings"].split()[ds.status.item()] == "not_finite"
    assert np.isfinite(ds.u[:step]).all() and np.isnan(ds.u[step:]).all()


def test_failure_of_newton_is_recorded_with_its_step():
    ds = study.run("softening", "average_acceleration", dt=1.14, steps=100, observe=["max_energy_error"])
    assert ds.status.attrs["flag_meanings"].split()[ds.status.item()] == "newton_not_converged"
    assert ds.failed_at_step >= 1
    assert np.isnan(ds.max_energy_error)


def test_failure_of_the_start_is_step_zero():
    ds = study.run("softening_large", "houbolt", dt=0.54, steps=10)
    assert ds.status == 1
    assert ds.failed_at_step == 0


def test_step_size_and_count_share_one_compilation():
    march_one._cached.clear_cache()
    for dt, steps in ((0.01, 10), (0.02, 20), (0.03, 30)):
        study.run("hardening", "houbolt", dt=dt, steps=steps, observe=["max_energy_error"])
    assert march_one._cached._cache_size() == 1


def test_what_a_problem_lacks_is_not_in_the_loop():
    """No load, no damping, no mass: nothing of time or of a linear solve is computed in the compiled loop."""
    problem, scheme = study.problems["hardening"], study.schemes["central_difference"]
    text = march_one.lower(problem, scheme, (), (), problem.u0, 0.01, 10).compile().compiled.as_text()
    assert "cosine" not in text and "custom-call" not in text and "divide" not in text
    loaded = study.Problem(problem.force, u0=1.5, load=lambda t: jax.numpy.cos(t), mass=2.0)
    text = march_one.lower(loaded, scheme, (), (), loaded.u0, 0.01, 10).compile().compiled.as_text()
    assert "cosine" in text and "divide" in text


def test_time_does_not_drift_over_many_steps():
    """The load of the last step is f(n Δt) to round-off, as time is a product and not a sum."""
    steps = 10**6
    problem = study.Problem(lambda u: 0.0 * u, u0=0.0, load=lambda t: t)
    ds = study.run(problem, "central_difference", dt=0.1, steps=steps, every=steps)
    end = 0.1 * steps
    # ü = t: velocity by the trapezoidal rule, exact for a linear function
    assert ds.v[-1].item() == pytest.approx(end**2 / 2, rel=1e-12)
