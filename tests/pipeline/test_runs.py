"""Runs that died are put away, and runs that live are left alone."""

import json
import os
import subprocess
import sys
import time
import zlib
from pathlib import Path

import psutil
import pytest

from study.pipeline import runs
from study.pipeline.runs import LOCKS, RUNS, Run


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty folder, in which everything happens."""
    monkeypatch.chdir(tmp_path)
    # dates of the sources are those of the project, which other tests use
    monkeypatch.setattr(runs, "SOURCES", ())
    monkeypatch.setattr(runs.platformdirs, "user_cache_path", lambda name: tmp_path / "cache" / name)
    return tmp_path


@pytest.fixture
def sleeper():
    """A process that sleeps until it is ended."""
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    yield process
    process.kill()
    process.wait()


def _died(pid: int = 2**22 - 3) -> Run:
    """The file of a run whose process is gone."""
    run = Run(runs.of_process(os.getpid()).host, pid, 1.0)
    RUNS.mkdir(parents=True, exist_ok=True)
    (RUNS / f"{run.name}.json").write_text(json.dumps(run))
    return run


def _locked() -> Path:
    LOCKS.mkdir(parents=True, exist_ok=True)
    lock = LOCKS / "0.input.lock"
    lock.write_text("config/study.yaml\n")
    return lock


def test_a_first_run_finds_nothing_and_is_entered():
    name, told = runs.entered(os.getpid())
    assert told == [] and runs.known() == [runs.of_process(os.getpid())]
    assert name == runs.known()[0].name


def test_the_lock_of_a_dead_run_is_lifted_and_its_unfinished_files_go():
    lock, run = _locked(), _died()
    Path("results/reference").mkdir(parents=True)
    unfinished, product = Path("results/reference/.x.nc.0123.unfinished"), Path("results/reference/x.nc")
    unfinished.write_text("half")
    product.write_text("whole")
    _, told = runs.entered(os.getpid())
    assert "the lock is lifted" in " ".join(told) and "no product among them: 1." in " ".join(told)
    assert not lock.exists() and not unfinished.exists() and product.read_text() == "whole"
    assert run not in runs.known()


def test_the_unfinished_file_of_a_writer_that_lives_stays(sleeper):
    _died()
    Path("results").mkdir()
    for number in (sleeper.pid, 2**22 - 3):
        Path(f"results/.x.nc.{number}.0123.unfinished").write_text("half")
    runs.entered(os.getpid())
    assert [file.name for file in Path("results").iterdir()] == [f".x.nc.{sleeper.pid}.0123.unfinished"]


def test_of_two_that_enter_at_once_one_finds_the_other():
    """Both meet a run that has died with a lock."""
    _locked(), _died()
    code = f"import sys, time; sys.path.insert(0, {str(Path(runs.__file__).parent)!r}); import runs, os; "
    code += "print(runs.entered(os.getpid()).name, flush=True); time.sleep(5)"
    both = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    names = [one.stdout.readline().strip() for one in both if one.stdout is not None]
    for one in both:
        one.kill()
        one.communicate()
    assert names.count("None") == 1


def test_the_lock_of_a_run_that_lives_is_respected(sleeper):
    runs.entered(sleeper.pid)
    lock = _locked()
    _died()
    name, told = runs.entered(os.getpid())
    assert name is None and lock.exists() and len(told) == 1
    assert told[0].startswith(f"process {sleeper.pid} on ") and told[0].endswith("wait for it, or end it.")


def test_another_process_with_the_number_of_a_dead_one_is_not_taken_for_it(sleeper):
    lock, run = _locked(), runs.of_process(sleeper.pid)
    RUNS.mkdir(parents=True)
    (RUNS / "old.json").write_text(json.dumps(run._replace(started=run.started - 100)))
    runs.entered(os.getpid())
    assert not lock.exists() and psutil.pid_exists(sleeper.pid)


def test_a_run_on_another_machine_counts_as_alive():
    lock = _locked()
    RUNS.mkdir(parents=True)
    (RUNS / "far.json").write_text(json.dumps(Run("another machine", 1, 1.0)))
    _, told = runs.entered(os.getpid())
    assert lock.exists() and "if it is dead, remove '" in told[0]


def test_a_half_written_file_of_a_run_is_no_run():
    RUNS.mkdir(parents=True)
    (RUNS / "half.json").write_text('["a", 1')
    assert runs.known() == [] and not list(RUNS.iterdir())


@pytest.mark.parametrize("deaf", [False, True])
def test_jobs_that_survived_a_dead_run_are_ended_and_no_others(sleeper, deaf, monkeypatch):
    monkeypatch.setattr(runs, "PATIENCE", 0.5)
    code = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); time.sleep(60)"
    code = code if deaf else "import time; print(flush=True); time.sleep(60)"
    job = subprocess.Popen(
        [sys.executable, "-c", code], env=os.environ | {runs.VARIABLE: _died().name}, stdout=subprocess.PIPE
    )
    assert job.stdout is not None and job.stdout.readline()
    _, told = runs.entered(os.getpid())
    assert "start anew: 1." in told[0]
    job.communicate(timeout=30)
    assert sleeper.poll() is None


def test_programs_that_cannot_be_read_are_removed_from_the_cache(tmp_path, monkeypatch):
    """Also without a run that died, and no matter when they were damaged."""
    folder = tmp_path / "cache" / "time-integration-study" / runs.platform.node()
    folder.mkdir(parents=True)
    program = zlib.compress(b"a program" * 100)
    contents = {"whole": program, "half": program[:20], "empty": b"", "other": b"\x28\xb5\x2f\xfd"}
    for name, content in contents.items():
        (folder / f"{name}-cache").write_bytes(content)
    (sentence,) = runs.removed_programs()
    assert sentence == "compiled programs in JAX's cache that cannot be read are removed: 2."
    assert {file.name for file in folder.iterdir()} == {"whole-cache", "other-cache"}
    (folder / "whole-cache").write_bytes(program[:-1])
    os.utime(folder / "whole-cache", (1.0, 1.0))
    assert len(list(runs.removed_programs())) == 1
    with monkeypatch.context() as patch:
        patch.setattr(runs, "_is_whole", lambda program: pytest.fail("it was read again"))
        assert list(runs.removed_programs()) == []


def test_the_run_of_a_folder_that_was_copied_is_no_run_of_the_copy(folder, sleeper, monkeypatch):
    """And neither it nor its jobs are ended."""
    original = runs.of_process(sleeper.pid)
    (folder / "copy").mkdir()
    monkeypatch.chdir(folder / "copy")
    RUNS.mkdir(parents=True)
    (RUNS / f"{original.name}.json").write_text(json.dumps(original))
    monkeypatch.setattr(runs, "end", lambda processes: pytest.fail("its jobs were ended"))
    job = subprocess.Popen(["sleep", "60"], env=os.environ | {runs.VARIABLE: original.name})
    name, told = runs.entered(os.getpid())
    job.kill()
    job.wait()
    assert name == runs.of_process(os.getpid()).name and told == [] and original not in runs.known()


def test_a_half_built_site_is_removed(sleeper):
    for number in (sleeper.pid, 2**22 - 3):
        Path(f"results/.site.{number}.0123.unfinished/pages").mkdir(parents=True)
    _, told = runs.entered(os.getpid())
    assert "no product among them: 1." in " ".join(told)
    assert [file.name for file in Path("results").iterdir()] == [f".site.{sleeper.pid}.0123.unfinished"]


def test_dates_in_the_future_are_set_to_now():
    Path("results").mkdir()
    for name, ahead in (("a.nc", 1e6), ("b.nc", -1e6), ("c.nc", 10.0)):
        Path("results", name).write_text(name)
        os.utime(Path("results", name), (time.time() + ahead,) * 2)
    dates = {file.name: file.stat().st_mtime for file in Path("results").iterdir()}
    _, told = runs.entered(os.getpid())
    assert told[0] == "dates that lay in the future, such as that of 'results/a.nc', are set to now: 1."
    after = {file.name: file.stat().st_mtime for file in Path("results").iterdir()}
    assert abs(after["a.nc"] - time.time()) < 60 and {name for name in dates if dates[name] != after[name]} == {"a.nc"}


def test_a_date_in_the_future_that_cannot_be_set_is_told_and_stops_nothing(monkeypatch):
    Path("results").mkdir()
    Path("results/a.nc").write_text("a")
    os.utime("results/a.nc", (1e10, 1e10))
    monkeypatch.setattr(os, "utime", lambda *_: os.mkdir("results"))  # an error of the system, also for root
    name, told = runs.entered(os.getpid())
    assert name is not None and told[0].startswith("the date of 'results/a.nc' lies in the future and cannot be set;")
