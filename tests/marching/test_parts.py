"""Ensembles in parts, each of which is one file."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr

import study
from study.io import NotRead
from study.marching import parts

RUN: dict[str, Any] = {
    "dt": 0.0075,
    "steps": 40,
    "observe": ["trajectory", "peak"],
    "every": 10,
    "u0": np.linspace(0.5, 1.5, 150),
}


def _hardening(folder, **changed):
    return study.run("hardening", "average_acceleration", **RUN | changed, save=folder)


def _spring(stiffness):
    return study.Problem(lambda u: stiffness * jnp.sin(u), u0=[1.0, 0.5], title="two springs")


@pytest.mark.slow
def test_parts_are_the_ensemble_to_the_last_bit(tmp_path):
    saved = _hardening(study.Parts(tmp_path, 3))
    whole = study.run("hardening", "average_acceleration", **RUN)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["part_0.nc", "part_1.nc", "part_2.nc"]
    np.testing.assert_array_equal(saved.lane, np.arange(150))
    assert saved.attrs.pop("run")
    xr.testing.assert_identical(saved.drop_vars("lane"), whole)


@pytest.mark.slow
def test_parts_of_a_family_hold_their_own_arguments(tmp_path):
    arguments = {"dt": 0.05, "steps": 40, "observe": ["trajectory", "peak"], "every": 40}
    over = {"stiffness": np.linspace([1.0, 2.0], [4.0, 9.0], 150)}
    saved = study.run(_spring, "rk4", **arguments, over=over, save=study.Parts(tmp_path, 2))
    whole = study.run(_spring, "rk4", **arguments, over=over)
    assert saved.attrs.pop("run")
    xr.testing.assert_identical(saved.drop_vars("lane"), whole)
    with xr.open_dataset(tmp_path / "part_1.nc") as part:
        np.testing.assert_array_equal(part.stiffness, over["stiffness"][75:])


def test_a_job_runs_one_part(tmp_path):
    part = _hardening(study.Parts(tmp_path, 3, only=1))
    np.testing.assert_array_equal(part.lane, np.arange(50, 100))
    assert [path.name for path in tmp_path.iterdir()] == ["part_1.nc"]
    first = (tmp_path / "part_1.nc").stat().st_mtime_ns
    assert _hardening(study.Parts(tmp_path, 3)).sizes["lane"] == 150
    assert (tmp_path / "part_1.nc").stat().st_mtime_ns == first


def test_the_default_parts_follow_from_lanes_and_bytes(tmp_path, monkeypatch):
    monkeypatch.setattr(parts, "MOST_LANES", 100)
    _hardening(tmp_path / "lanes")
    assert len(list((tmp_path / "lanes").iterdir())) == 2
    # five samples of displacement and velocity, peak, failure, u0, v0 and dt of 8 bytes each
    monkeypatch.setattr(parts, "MOST_BYTES", 8 * 15 * 30)
    _hardening(tmp_path / "bytes")
    assert len(list((tmp_path / "bytes").iterdir())) == 5


KILLED = """
import sys
import numpy as np
import study

u0 = np.linspace(0.5, 1.5, 600)
study.run("hardening", "rk4", dt=0.0075, steps=2000, observe="peak", u0=u0, save=study.Parts(sys.argv[1], 12))
"""


def test_a_run_that_was_killed_goes_on_with_the_first_missing_part(tmp_path):
    def finished():
        return sorted(tmp_path.glob("part_*.nc"))

    killed = subprocess.Popen([sys.executable, "-c", KILLED, str(tmp_path)])
    while len(finished()) < 2:
        assert killed.poll() is None
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    before = {path: path.stat().st_mtime_ns for path in finished()}
    assert 2 <= len(before) < 12
    leftover = tmp_path / f".part_{len(before):02}.nc.1.ab.unfinished"  # as if it was killed while it wrote
    leftover.write_bytes(b"CDF")
    arguments: dict[str, Any] = {"dt": 0.0075, "steps": 2000, "observe": "peak", "u0": np.linspace(0.5, 1.5, 600)}
    saved = study.run("hardening", "rk4", **arguments, save=study.Parts(tmp_path, 12))
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert len(list(tmp_path.iterdir())) == len(finished()) == 12
    np.testing.assert_array_equal(saved.peak, study.run("hardening", "rk4", **arguments).peak)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changed",
    [{"dt": 0.0076}, {"steps": 50}, {"every": 20}, {"bound": 9.0}, {"observe": ["peak"]}, {"u0": RUN["u0"][::-1]}],
    ids=lambda changed: next(iter(changed)),
)
def test_a_folder_of_another_run_is_refused(tmp_path, changed):
    _hardening(study.Parts(tmp_path, 3, only=2))
    for refused in (study.Parts(tmp_path, 3), study.Parts(tmp_path, 3, only=1)):
        with pytest.raises(ValueError, match=r"^'.*part_2.nc' is of another run, .*: give this run another folder\.$"):
            _hardening(refused, **changed)


def test_a_force_that_was_edited_is_another_run(tmp_path):
    def run(force, count=2):
        problem = study.Problem(force, 1.0, title="edited")
        study.run(problem, "rk4", dt=0.1, steps=3, u0=np.ones(10), observe="peak", save=study.Parts(tmp_path, count))

    run(lambda u: 4.0 * u)
    run(lambda u: 4.0 * u)
    for other in (lambda u: 5.0 * u, lambda u: 4.0 * u**3):
        with pytest.raises(ValueError, match="another run"):
            run(other)
    with pytest.raises(ValueError, match="another run"):
        run(lambda u: 4.0 * u, count=5)


def test_a_damaged_part_is_named(tmp_path):
    _hardening(study.Parts(tmp_path, 3))
    (tmp_path / "part_1.nc").write_bytes(b"CDF")
    with pytest.raises(NotRead, match=r"^'.*part_1.nc' cannot be used, because it is missing or damaged"):
        _hardening(study.Parts(tmp_path, 3))


def test_a_warning_numbers_the_lanes_of_the_whole_ensemble(tmp_path):
    u0 = np.where(np.arange(150) == 120, 1e6, 1.0)
    with pytest.warns(study.RunFailedWarning, match="1 of 50 runs failed, the first of them, lane 120: "):
        saved = _hardening(study.Parts(tmp_path, 3), u0=u0, bound=1e3)
    np.testing.assert_array_equal(np.flatnonzero(saved.status), 120)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"u0": 1.0}, r"save writes the parts of an ensemble; a single run is written by its method to_netcdf\."),
        ({"save": (0,)}, r"an ensemble of 150 lanes has 1 to 150 parts, not 0\."),
        ({"save": (151,)}, r"an ensemble of 150 lanes has 1 to 150 parts, not 151\."),
        ({"save": (3, 3)}, r"the number of one of 3 parts is at least 0 and less than 3, not 3\."),
    ],
)
def test_a_mistake_is_named(tmp_path, changed, sentence):
    save = study.Parts(tmp_path, *changed.pop("save", ()))
    with pytest.raises(ValueError, match=f"^{sentence}$"):
        _hardening(save, **changed)


def test_a_run_with_a_tolerance_has_no_parts(tmp_path):
    with pytest.raises(TypeError, match="save belongs to an ensemble with equal steps"):
        study.run("hardening", "rk4", tolerance=[1e-3, 1e-4], duration=1.0, save=Path(tmp_path))
