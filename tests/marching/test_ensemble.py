"""Ensembles give the same results as single runs."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr

import study
from study.marching import ensemble, kernel, program
from study.marching.march import March
from study.marching.result import UNBOUNDED
from study.marching.run import sweep
from study.scheme.wrapper.linearised import Linearised
from study.settings import cores


@pytest.mark.slow
def test_a_lane_of_an_ensemble_is_a_single_run(state_kind):
    u0, dt = np.linspace(0.5, 2.0, 7), np.linspace(0.001, 0.02, 7)
    observe = ["trajectory", "max_energy_error", "newton_iterations"]
    lanes = study.run("hardening", state_kind, dt=dt, u0=u0, steps=40, observe=observe)
    for lane in range(7):
        run = study.run("hardening", state_kind, dt=dt[lane], u0=u0[lane], steps=40, observe=observe)
        for name in run.data_vars:
            np.testing.assert_allclose(lanes[name][lane], run[name], rtol=1e-9, atol=1e-9, err_msg=name)
    assert lanes.t.dims == ("lane", "sample")


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "houbolt"])
def test_lanes_end_after_their_own_steps(scheme):
    steps, u0 = np.array([40, 3, 170, 1, 90]), np.linspace(0.5, 2.0, 5)
    observe = ["max_energy_error", "energy_drift", "newton_iterations"]
    lanes = study.run("hardening", scheme, dt=0.004, u0=u0, steps=steps, observe=observe)
    for lane in range(5):
        run = study.run("hardening", scheme, dt=0.004, u0=u0[lane], steps=int(steps[lane]), observe=observe)
        for name in run.data_vars:
            np.testing.assert_allclose(lanes[name][lane], run[name], rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("group, workers", [(1, "1"), (3, "2")])
def test_neighbours_and_cores_change_no_bit(monkeypatch, group, workers):
    """The order of lanes, the size of the ensemble and the number of cores change no bit of a lane's results.

    Lanes with large step sizes fail.
    """
    dt, u0 = np.linspace(0.001, 0.5, 700), np.linspace(0.1, 3.0, 700)

    def result(scheme, lanes):
        observe = ["max_energy_error", "newton_iterations"]
        arguments = {"dt": dt[lanes], "u0": u0[lanes], "steps": 200, "observe": observe}
        return sweep("softening", scheme, **arguments, bound=3.2)

    before = {scheme: result(scheme, slice(None)) for scheme in ("houbolt", "rk4")}
    monkeypatch.setattr(ensemble, "GROUPS", (group,))
    monkeypatch.setenv("OMP_NUM_THREADS", workers)
    assert cores() == int(workers) and 0 < (before["rk4"].status > 0).sum() < 100
    for scheme, ds in before.items():
        for lanes in (slice(None), np.random.default_rng(0).permutation(700), [699], slice(100, 107)):
            xr.testing.assert_identical(result(scheme, lanes), ds.isel(lane=lanes))


@pytest.mark.slow
def test_an_ensemble_on_an_accelerator_is_one_tile(monkeypatch):
    arguments = {"dt": 0.01, "u0": np.linspace(0.5, 2.0, 20), "steps": 50, "observe": ["max_energy_error"]}
    on_cpu = study.run("hardening", "rk4", **arguments)
    monkeypatch.setattr(ensemble.jax, "default_backend", lambda: "gpu")
    monkeypatch.setattr(kernel, "is_chosen", lambda unknowns: False)  # a kernel needs a GPU
    xr.testing.assert_allclose(study.run("hardening", "rk4", **arguments), on_cpu, rtol=1e-12)


@pytest.mark.slow
def test_a_pause_changes_no_bit_of_an_ensemble(monkeypatch):
    arguments = {"dt": np.linspace(0.001, 0.1, 300), "steps": 500, "observe": ["trajectory", "max_energy_error"]}
    at_once = study.run("softening", "average_acceleration", **arguments, every=10)
    monkeypatch.setattr(program, "PAUSE_OF_LANES", 70 * 512)
    xr.testing.assert_identical(study.run("softening", "average_acceleration", **arguments, every=10), at_once)


@pytest.mark.slow
@pytest.mark.skipif(jax.default_backend() != "cpu", reason="on an accelerator all lanes are one group")
def test_short_and_long_groups_use_one_program(monkeypatch, compiled):
    """The first group of lanes ends before the first pause, and the last one after it."""
    monkeypatch.setattr(ensemble, "GROUPS", (1,))
    steps = np.repeat([10, 300], ensemble.TILE)
    arguments = {"dt": 0.001, "u0": np.linspace(0.5, 2.0, len(steps)), "observe": ["max_energy_error"]}
    with monkeypatch.context() as patched:
        patched.setattr(program, "PAUSE_OF_LANES", 100 * ensemble.TILE)
        in_stretches = study.run("hardening", "rk4", steps=steps, **arguments)
    before = len(compiled)
    xr.testing.assert_identical(study.run("hardening", "rk4", steps=steps, **arguments), in_stretches)
    assert len(compiled) == before + 1  # the program without stretches


def test_a_failed_lane_leaves_the_others_alone():
    dt = [0.001, 0.9, 0.002]
    lanes = study.run("hardening", "central_difference", dt=dt, steps=100, observe=["trajectory", "max_energy_error"])
    assert lanes.status.values.tolist() == [0, UNBOUNDED, 0]
    assert np.isnan(lanes.max_energy_error[1]) and np.isfinite(lanes.max_energy_error[[0, 2]]).all()
    failed = int(lanes.failed_at_step[1])
    assert np.isfinite(lanes.u[1, :failed]).all() and np.isnan(lanes.u[1, failed:]).all()
    assert np.isfinite(lanes.u[[0, 2]]).all()


@pytest.mark.slow
def test_a_failed_lane_is_frozen_whole_with_its_neighbour():
    definition = March(
        study.problems["double_well"], Linearised(scheme=study.schemes["average_acceleration"]), (), (), lanes=True
    )
    dt = jnp.asarray([0.1, 3.5])
    progress, initial, stored = definition.start(jnp.full(2, 0.5), jnp.zeros(2), dt, 1)
    progress, _ = definition.proceed(progress, stored, initial, dt, 1000, 1, 0, each_step=False)
    # a multiple of 3 means that no balance was found; a value below 3000, that the lane failed before the last step
    assert progress.failure[0] == 0 and progress.failure[1] % 3 == 0 < progress.failure[1] < 3000
    # the state of the failed lane is NaN, which ends Newton's iteration at once
    assert all(np.isnan(part[1]) and np.isfinite(part[0]) for part in jax.tree.leaves(progress.state.inner))


def test_the_longest_lanes_fill_their_tiles_and_every_group_has_some():
    """Empty places in the tiles of the longest lanes, or all long lanes in one group. Only this test catches either."""
    tiles = ensemble._in_tiles(np.arange(150.0), (2, 2, 64), 8, np.nan)
    assert tiles.shape == (2, 8, 64) and np.isnan(tiles[:, 2:]).all()
    np.testing.assert_array_equal(tiles[:, 1], np.arange(22.0, 150.0).reshape(2, 64))
    np.testing.assert_array_equal(tiles[1, 0, -22:], np.arange(22.0))
