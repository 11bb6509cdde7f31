"""The pipeline on a Slurm of one node: its products equal the products of a local run, also after interrupted jobs."""

import os
import platform
import runpy
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from tests.pipeline.pipeline import SMALL, call_snakemake, copied

#: Products: datasets of jobs on the node, figures of one group, and a dataset of measured times.
PRODUCTS = ["energy_drift.nc", "houbolt_start.nc", "figures/energy_drift.pdf", "figures/bifurcation.pdf", "cpu_time.nc"]
#: Products without measured times, which must have the same bytes as in a local run.
UNTIMED = PRODUCTS[:-1]
#: Options of Snakemake for a Slurm without accounting: the state of a job is read from the queue.
OPTIONS = "--workflow-profile profiles/slurm --slurm-status-command squeue --slurm-no-account".split()
#: Option for the seconds before a check of the queue. The number is smaller than in the profile, as jobs are short.
SOON = "--slurm-init-seconds-before-status-checks", "2"


@pytest.fixture(scope="module", autouse=True)
def slurm():
    """Start Slurm; without Slurm, its plugin or the rights of root, tests are skipped with a reason."""
    if shutil.which("slurmctld") is None or find_spec("snakemake_executor_plugin_slurm") is None or os.getuid():
        pytest.skip("a Slurm needs root, Debian's slurm-wlm and munge, and the extra 'slurm' of this package")
    subprocess.run([Path(__file__).with_name("start")], check=True)


@pytest.fixture(scope="module")
def local(tmp_path_factory) -> Path:
    """A copy of the project with products of a local run."""
    folder = copied(tmp_path_factory.mktemp("local"))
    process = call_snakemake(folder, *_targets(UNTIMED))
    assert process.returncode == 0, process.stderr[-4000:]
    return folder


@pytest.fixture
def folder(tmp_path) -> Path:
    """A copy of the project without products."""
    return copied(tmp_path)


def _targets(products: list[str]) -> list[str]:
    return [f"results/{name}" for name in products]


def _started(folder: Path, products: list[str], *options: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "snakemake", *_targets(products), *OPTIONS, *options, "--configfile", str(SMALL)]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    with (folder / "slurm.log").open("a") as log:
        return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env=environment)


def _run_log(folder: Path, products: list[str]) -> str:
    run = _started(folder, products, *SOON)
    run.wait(timeout=400)
    log = (folder / "slurm.log").read_text()
    assert run.returncode == 0, log[-4000:]
    return log


def _same(folder: Path, local: Path, products: list[str]) -> None:
    for name in products:
        assert (folder / "results" / name).read_bytes() == (local / "results" / name).read_bytes(), name


def _queue(folder: Path, *states: str) -> list[str]:
    chosen = [f"--states={','.join(states)}"] if states else []
    listed = subprocess.run(
        ["squeue", "--noheader", "--format=%i %Z", *chosen], capture_output=True, text=True, check=True
    )
    return [line.split()[0] for line in listed.stdout.splitlines() if Path(line.split(None, 1)[1]) == folder]


def _wait(condition: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "what the test waits for did not happen"
        time.sleep(0.2)


def test_a_cluster_makes_the_bytes_of_a_local_run_and_sends_figures_together(folder, local):
    log = _run_log(folder, PRODUCTS)
    _same(folder, local, UNTIMED)
    assert log.count("has been submitted with SLURM jobid") == 5
    assert (folder / "results" / "cpu_time.nc").exists()


def test_a_job_that_is_cancelled_starts_again(folder, local):
    run = _started(folder, UNTIMED[:2], *SOON)
    _wait(lambda: _queue(folder, "RUNNING"))
    subprocess.run(["scancel", _queue(folder, "RUNNING")[0]], check=True)
    run.wait(timeout=300)
    assert run.returncode == 0, (folder / "slurm.log").read_text()[-4000:]
    _same(folder, local, UNTIMED[:2])


def test_a_node_that_goes_and_comes_back_is_survived(folder, local):
    run, node = _started(folder, UNTIMED[:2], *SOON), platform.node().split(".")[0]
    _wait(lambda: _queue(folder, "RUNNING"))
    subprocess.run(["scontrol", "update", f"nodename={node}", "state=down", "reason=test"], check=True)
    try:
        _wait(lambda: not _queue(folder, "RUNNING"))
    finally:
        # errors are ignored, because a node that has returned by itself cannot be resumed
        subprocess.run(["scontrol", "update", f"nodename={node}", "state=resume"], check=False)
        for number in _queue(folder, "PENDING"):  # Slurm lets a requeued job wait for two minutes
            subprocess.run(["scontrol", "update", f"jobid={number}", "starttime=now"], check=True)
    run.wait(timeout=300)
    assert run.returncode == 0, (folder / "slurm.log").read_text()[-4000:]
    _same(folder, local, UNTIMED[:2])


def test_jobs_of_a_killed_run_are_cancelled_by_the_next(folder, local):
    run = _started(folder, UNTIMED[:2])
    _wait(lambda: _queue(folder))
    jobs = set(_queue(folder))
    run.kill()
    run.wait()
    _run_log(folder, UNTIMED[:2])
    assert not jobs & set(_queue(folder))
    _same(folder, local, UNTIMED[:2])


def test_an_ensemble_in_parts_goes_on_after_its_jobs_and_their_snakemake_were_killed(folder):
    def finished():
        return {path: path.stat().st_mtime_ns for path in (folder / "runs").glob("part_*.nc")}

    ensemble = ["--snakefile", "examples/parts.smk", *OPTIONS, *SOON, "--config", "lanes=600", "parts=3"]
    command = [sys.executable, "-m", "snakemake", *ensemble]
    run = subprocess.Popen([*command, "--jobs", "1"], cwd=folder)
    _wait(lambda: _queue(folder, "RUNNING"), 120)
    first = _queue(folder)
    _wait(lambda: _queue(folder, "RUNNING") not in ([], first), 300)
    stamps = finished()
    run.kill()
    run.wait()
    subprocess.run(["scancel", "--signal=KILL", *_queue(folder)], check=True)
    _wait(lambda: not _queue(folder))
    assert len(stamps) == 1
    subprocess.run(command, cwd=folder, check=True, timeout=600)
    assert {path: stamp for path, stamp in finished().items() if path in stamps} == stamps
    ds = xr.concat([xr.load_dataset(path) for path in sorted(finished())], "lane")
    fragility = runpy.run_path(f"{folder / 'examples' / 'intensities.py'}")["fragility"]
    np.testing.assert_array_equal(ds.drift, fragility(600).drift)
    assert "of 600 exceed 40 mm" in (folder / "shares.txt").read_text()


def test_a_run_that_is_interrupted_ends_within_seconds_and_leaves_no_jobs(folder):
    run = _started(folder, UNTIMED[:2])
    _wait(lambda: _queue(folder, "RUNNING"))
    run.send_signal(signal.SIGINT)
    run.wait(timeout=15)
    assert run.returncode != 0
    assert not _queue(folder, "PENDING", "RUNNING")
    _wait(lambda: not _queue(folder))  # Slurm waits half a minute for a process that does not end by itself
