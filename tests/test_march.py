"""The compiled march: what it observes, how it fails, and that ensembles are many single runs."""

import os
import signal
import subprocess
import sys
import time

import jax
import numpy as np
import pytest
import xarray as xr

import study
from study import settings
from study.marching import ensemble
from study.marching import run as runs
from study.marching.march import March, march


def test_reductions_agree_with_the_trajectory(kind):
    problem = study.problems["hardening"]
    ds = study.run(
        "hardening",
        kind,
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


def test_storing_every_tenth_step_takes_them_out_of_the_whole(kind):
    whole, tenth = (study.run("softening", kind, dt=0.05, steps=200, every=k) for k in (1, 10))
    np.testing.assert_allclose(tenth.u, whole.u[::10], atol=1e-11)
    np.testing.assert_array_equal(tenth.t, whole.t[::10])


def test_newton_iterations_are_counted():
    ds = study.run("hardening", "average_acceleration", dt=0.15 / 20, steps=100, observe=["newton_iterations"])
    assert 100 < ds.newton_iterations.item() < 600
    assert 2 <= ds.max_newton_iterations.item() <= 10


def test_a_lane_of_an_ensemble_is_a_single_run(kind):
    u0, dt = np.linspace(0.5, 2.0, 7), np.linspace(0.001, 0.02, 7)
    observe = ["trajectory", "max_energy_error", "newton_iterations"]
    lanes = study.run("hardening", kind, dt=dt, u0=u0, steps=40, observe=observe)
    for lane in range(7):
        one = study.run("hardening", kind, dt=dt[lane], u0=u0[lane], steps=40, observe=observe)
        for name in one.data_vars:
            np.testing.assert_allclose(lanes[name][lane], one[name], rtol=1e-9, atol=1e-9, err_msg=name)
    assert lanes.t.dims == ("lane", "sample")


def test_lanes_end_after_their_own_steps(kind):
    steps, u0 = np.array([40, 3, 170, 1, 90]), np.linspace(0.5, 2.0, 5)
    observe = ["max_energy_error", "energy_drift", "newton_iterations"]
    lanes = study.run("hardening", kind, dt=0.004, u0=u0, steps=steps, observe=observe)
    for lane in range(5):
        one = study.run("hardening", kind, dt=0.004, u0=u0[lane], steps=int(steps[lane]), observe=observe)
        for name in one.data_vars:
            np.testing.assert_allclose(lanes[name][lane], one[name], rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("group, workers", [(1, "1"), (3, "2")])
def test_neighbours_and_cores_change_no_bit(monkeypatch, group, workers):
    """Of lanes in another order and in smaller ensembles, some of which fail or take many Newton iterations."""
    dt, u0 = np.linspace(0.001, 0.2, 700), np.linspace(0.1, 3.0, 700)

    def result(scheme, lanes):
        observe = ["max_energy_error", "newton_iterations"]
        return study.run("softening", scheme, dt=dt[lanes], u0=u0[lanes], steps=200, observe=observe)

    before = {scheme: result(scheme, slice(None)) for scheme in ("average_acceleration", "houbolt", "rk4")}
    monkeypatch.setattr(ensemble, "GROUP", group)
    monkeypatch.setenv("OMP_NUM_THREADS", workers)
    assert ensemble.cores() == int(workers)
    for scheme, ds in before.items():
        for lanes in (slice(None), np.random.default_rng(0).permutation(700), [699], slice(100, 107)):
            xr.testing.assert_identical(result(scheme, lanes), ds.isel(lane=lanes))


def test_an_ensemble_on_an_accelerator_is_one_tile(monkeypatch):
    arguments = {"dt": 0.01, "u0": np.linspace(0.5, 2.0, 20), "steps": 50, "observe": ["max_energy_error"]}
    on_cpu = study.run("hardening", "rk4", **arguments)
    monkeypatch.setattr(ensemble.jax, "default_backend", lambda: "gpu")
    xr.testing.assert_allclose(study.run("hardening", "rk4", **arguments), on_cpu, rtol=1e-12)


@pytest.mark.parametrize("u0", [4.0, [4.0, 5.0]])
def test_a_number_of_samples_fits_runs_of_every_length(u0):
    arguments = {"problem": "softening", "scheme": "rk4", "dt": 0.05, "u0": u0}
    whole = study.run(**arguments, steps=50).u
    for steps in (7, 30, 50):
        some = study.run(**arguments, steps=steps, every=3, samples=10).u
        ended = np.arange(11) * 3 > steps
        np.testing.assert_array_equal(some.t, whole.t[:31:3])
        np.testing.assert_allclose(some.isel(t=~ended), whole[..., :31:3].isel(t=~ended), rtol=1e-12)
        assert some.isel(t=ended).isnull().all()
    with pytest.raises(ValueError, match="samples must be a whole number of at least 1, not 0"):
        study.run(**arguments, steps=7, samples=0)


@pytest.mark.parametrize("every", [1, 10, 1000])
def test_a_pause_changes_nothing(monkeypatch, every):
    """Also where it falls between two samples."""
    arguments = {"dt": 0.002, "steps": 3000, "every": every, "observe": ["trajectory", "max_energy_error"]}
    at_once = study.run("softening", "houbolt", **arguments)
    monkeypatch.setattr(runs, "PAUSE", 257)
    xr.testing.assert_allclose(study.run("softening", "houbolt", **arguments), at_once, rtol=1e-10, atol=1e-12)


def test_a_failure_ends_a_run_at_its_pause(monkeypatch):
    monkeypatch.setattr(runs, "PAUSE", 8)
    ds = study.run("double_well", "central_difference", dt=2.5, steps=10**12, observe=["max_energy_error"])
    assert ds.status == 2 and ds.failed_at_step < 100


@pytest.mark.parametrize("u0", ["1.5", "[1.0] * 2000"], ids=["alone", "ensemble"])
def test_a_long_run_can_be_interrupted(tmp_path, u0):
    """Ctrl-C is heard while a run of a million million steps is under way, and leaves what was written."""
    code = (
        # who runs the tests in the background has interrupts switched off
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "import study; study.datasets.write(study.run('hardening', 'rk4', dt=1e-4, steps=10), 'kept.nc'); "
        "print('ready', flush=True); "
        f"study.run('hardening', 'rk4', dt=1e-4, u0={u0}, steps=10**12, observe=['max_energy_error'])"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, **pipes) as process:
        try:
            assert process.stdout.readline() == b"ready\n"
            time.sleep(2)
            process.send_signal(signal.SIGINT)
            _, error = process.communicate(timeout=60)
        finally:
            process.kill()  # which it would otherwise survive by weeks
    assert process.returncode != 0 and b"KeyboardInterrupt" in error
    assert xr.load_dataset(tmp_path / "kept.nc").status == 0


def test_a_pause_changes_no_bit_of_an_ensemble(monkeypatch):
    arguments = {"dt": np.linspace(0.001, 0.1, 300), "steps": 500, "observe": ["trajectory", "max_energy_error"]}
    at_once = study.run("softening", "average_acceleration", **arguments, every=10)
    monkeypatch.setattr(ensemble, "PAUSE", 70 * 512)
    xr.testing.assert_identical(study.run("softening", "average_acceleration", **arguments, every=10), at_once)


def test_jax_in_use_before_the_import_is_told():
    code = "import jax.numpy as jnp; jnp.ones(3).sum(); import study"
    environment = {name: value for name, value in os.environ.items() if name != "XLA_FLAGS"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert "JAX has computed something before study was imported" in done.stderr
    assert "XLA_FLAGS='" in done.stderr


def test_a_second_process_compiles_nothing(tmp_path):
    code = (
        "import jax, study; hits = []; "
        "jax.monitoring.register_event_listener(lambda name, **_: hits.append(name.rsplit('/', 1)[-1])); "
        "study.run('hardening', 'houbolt', dt=1e-3, steps=10); print(hits.count('cache_misses'))"
    )
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    misses = [
        int(subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True).stdout)
        for _ in range(2)
    ]
    assert misses[0] > 0 and misses[1] == 0


def test_a_cache_that_has_grown_too_large_loses_its_older_half(tmp_path, monkeypatch):
    for age in range(10):
        (tmp_path / f"program{age}").write_bytes(bytes(100))
        os.utime(tmp_path / f"program{age}", (0, 1000 - age))
    settings._prune(tmp_path)
    assert len(list(tmp_path.iterdir())) == 10
    monkeypatch.setattr(settings, "_CACHE_SIZE", 999)
    settings._prune(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {f"program{age}" for age in range(5)}


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
    march._cached.clear_cache()
    for dt, steps in ((0.01, 10), (0.02, 20), (0.03, 30)):
        study.run("hardening", "houbolt", dt=dt, steps=steps, observe=["max_energy_error"])
    assert march._cached._cache_size() == 1


def test_what_a_problem_lacks_is_not_in_the_loop():
    """No load, no damping, no mass: nothing of time or of a linear solve is computed in the compiled loop."""
    problem, scheme = study.problems["hardening"], study.schemes["central_difference"]

    def compiled(of):
        numbers = map(np.asarray, (of.u0, 0.01, 10, 1))
        return march.lower(March(of, scheme, (), ()), *numbers).compile().compiled.as_text()

    text = compiled(problem)
    assert "cosine" not in text and "custom-call" not in text and "divide" not in text
    loaded = study.Problem(problem.force, u0=1.5, load=lambda t: jax.numpy.cos(t), mass=2.0)
    text = compiled(loaded)
    assert "cosine" in text and "divide" in text


def test_time_does_not_drift_over_many_steps():
    """The load of the last step is f(n Δt) to round-off, as time is a product and not a sum."""
    steps = 10**6
    problem = study.Problem(lambda u: 0.0 * u, u0=0.0, load=lambda t: t)
    ds = study.run(problem, "central_difference", dt=0.1, steps=steps, every=steps)
    end = 0.1 * steps
    # ü = t: velocity by the trapezoidal rule, exact for a linear function
    assert ds.v[-1].item() == pytest.approx(end**2 / 2, rel=1e-12)
