"""Interrupted, killed and concurrent calls of the pipeline, on datasets that take seconds."""

import io
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import psutil
import pytest

from pipeline import worker
from tests.pipeline.pipeline import SMALL, SNAKEMAKE, call_snakemake, copied, hashes_of, make

TARGETS = ["energy_drift.nc", "houbolt_start.nc"]
PATHS = [f"results/{target}" for target in TARGETS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A copy of the project in which the datasets have been made."""
    folder = copied(tmp_path_factory.mktemp("project"))
    make(folder, *TARGETS)
    return folder


def test_each_job_states_its_own_time_and_memory(folder):
    """A job runs in a child of the worker, which holds the study and JAX: over 100 MB."""
    for target in TARGETS:
        file = folder / "results" / "benchmarks" / f"{Path(target).stem}.tsv"
        taken = pd.read_csv(file, sep="\t").iloc[0]
        assert taken.max_rss > 100 and 0.05 < taken.cpu_time < 20 * taken.s


@pytest.fixture(scope="module")
def undisturbed(folder) -> dict[str, str]:
    """Digests of the datasets as the first run made them."""
    return hashes_of(folder)


@pytest.fixture
def running(folder, undisturbed):
    """A process of Snakemake that has begun to make the datasets again."""
    for target in TARGETS:
        (folder / "results" / target).unlink(missing_ok=True)
    leftover = folder / "results" / ".site.1.ab.unfinished"
    leftover.mkdir()
    (leftover / "index.html").touch()
    command = [*SNAKEMAKE, *PATHS, "--configfile", str(SMALL)]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0"}
    with (folder / "log").open("w") as log:
        run = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, env=environment, start_new_session=True)
    _wait(lambda: len(_processes(folder)) > 3)
    assert not leftover.exists()
    yield run
    if run.poll() is None:
        run.kill()
    run.wait()
    _wait(lambda: not _processes(folder))


def _processes(folder: Path) -> list[psutil.Process]:
    return [process for process in psutil.process_iter(["cwd"]) if process.info["cwd"] == str(folder)]


def _wait(condition, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "what the test waits for did not happen"
        time.sleep(0.05)


def test_a_second_run_ends_with_a_sentence_and_an_interrupt_the_first(folder, running):
    """Two runs that write the same results, and processes that survive Ctrl-C."""
    # the first run is paused; otherwise it might end before the second run checks for it
    os.killpg(running.pid, signal.SIGSTOP)
    done = call_snakemake(folder, *PATHS)
    assert done.returncode != 0 and f"another run is at work in '{folder}': wait for it, or end it." in done.stderr
    assert "Traceback" not in done.stderr
    assert call_snakemake(folder, "-n").returncode == 0
    # an interrupt ends the run and all its processes within seconds
    os.killpg(running.pid, signal.SIGCONT)
    os.killpg(running.pid, signal.SIGINT)
    assert running.wait(timeout=15) != 0
    _wait(lambda: not _processes(folder), 15)


def test_no_process_outlives_a_run_that_is_killed(folder, running):
    """A worker that goes on after Snakemake is killed."""
    running.kill()
    _wait(lambda: not _processes(folder), 15)


def test_the_pipeline_goes_on_without_its_worker_and_after_interrupts(folder, running, undisturbed):
    """After the worker is killed, jobs run without it, and the datasets equal those of an undisturbed run."""
    _wait(
        lambda: any("pipeline.worker" in " ".join(child.cmdline()) for child in psutil.Process(running.pid).children())
    )
    (worker,) = (child for child in psutil.Process(running.pid).children() if "pipeline.worker" in child.cmdline())
    worker.kill()
    running.wait()
    make(folder, *TARGETS)
    assert hashes_of(folder).items() >= undisturbed.items()


def test_the_snakefile_of_the_catalogue_plans_the_same_jobs(folder):
    """A path that holds only for the snakefile at the top, so that the one in the folder workflow plans other jobs."""

    def planned(snakefile):
        done = call_snakemake(folder, "-n", "--forceall", "--snakefile", snakefile)
        assert done.returncode == 0, done.stderr[-4000:]
        return [line for line in done.stdout.splitlines() if re.match(r"\w+ +\d+$", line)]

    jobs = planned("snakefile")
    assert len(jobs) > 30 and planned("workflow/Snakefile") == jobs
    linted = call_snakemake(folder, "--lint", "--snakefile", "workflow/Snakefile")
    assert linted.returncode == 0, (linted.stdout + linted.stderr)[-4000:]


def test_results_that_cannot_be_written_are_named(folder, tmp_path):
    """A traceback of Snakemake where the folder of results cannot be made."""
    (tmp_path / "results").write_text("a file where a folder should be")
    options = "--directory", str(tmp_path), "--snakefile", str(folder / "snakefile")
    done = call_snakemake(folder, PATHS[0], *options)
    assert done.returncode != 0
    assert "'results/logs' cannot be written: Not a directory." in done.stderr and "Traceback" not in done.stderr


def test_a_message_goes_to_the_terminal_if_the_disk_of_the_log_is_full(monkeypatch, tmp_path):
    with io.FileIO("/dev/full", "w") as full, open(tmp_path / "terminal", "wb", buffering=0) as terminal:
        monkeypatch.setattr(sys, "stderr", io.TextIOWrapper(full, write_through=True))
        worker._say("the disk is full", terminal.fileno())
    assert (tmp_path / "terminal").read_text() == "the disk is full\n"
