"""Files appear whole or not at all, whoever writes beside, and say why they do not."""

import multiprocessing
import resource
import shutil
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from paper import writing as of_paper
from study import datasets
from study.writing import NotWritten, check_writable, lack_of_room, whole

#: Seconds for which writers and readers meet.
MEETING = 3.0


def _dataset(value: float) -> xr.Dataset:
    values = np.random.default_rng(int(value)).random(20_000)
    values[0] = value
    return xr.Dataset({"x": ("i", values)}, attrs={"source": datasets.SOURCE})


def _write(path: Path, value: int, failures) -> None:
    end = time.monotonic() + MEETING
    while time.monotonic() < end:
        try:
            datasets.write(_dataset(value), path)
        except Exception as error:
            failures.put(f"writer {value}: {error!r}")


def _read(path: Path, failures, reads) -> None:
    end = time.monotonic() + MEETING
    while time.monotonic() < end:
        try:
            value = datasets.read(path).x.values[0]
            assert value in (1, 2), value
            reads.put(value)
        except Exception as error:
            failures.put(f"reader: {error!r}")


def test_two_writers_and_three_readers_never_meet_half_a_file(tmp_path):
    path, spawn = tmp_path / "one.nc", multiprocessing.get_context("spawn")
    datasets.write(_dataset(1), path)
    failures, reads = spawn.Queue(), spawn.Queue()
    people = [spawn.Process(target=_write, args=(path, value, failures)) for value in (1, 2)]
    people += [spawn.Process(target=_read, args=(path, failures, reads)) for _ in range(3)]
    for one in people:
        one.start()
    # a process ends once its queues are read
    seen: set[int] = set()
    failed: set[str] = set()
    while any(one.is_alive() for one in people):
        for queue, told in ((reads, seen), (failures, failed)):
            while not queue.empty():
                told.add(queue.get())
        time.sleep(0.01)
    assert not failed
    assert seen == {1, 2}
    assert [one.name for one in tmp_path.iterdir()] == ["one.nc"]


def _fill(kind: str, path: Path, limit: int, answers) -> None:
    """Write more than a file may hold, which a library meets as it meets a full disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        if kind == "dataset":
            datasets.write(_dataset(2), path)
        elif kind == "page":
            with whole(path) as unfinished:
                unfinished.write_text("x" * 1_000_000)
        else:
            of_paper.write(path, "x" * 1_000_000)
    except (NotWritten, SystemExit) as error:
        answers.put(str(error))


@pytest.mark.skipif(sys.platform == "win32", reason="limits of files are those of POSIX")
@pytest.mark.parametrize("kind", ["dataset", "page", "paper"])
def test_a_file_that_does_not_fit_is_refused_in_a_sentence_and_leaves_what_was_there(tmp_path, kind):
    path, spawn = tmp_path / "one.nc", multiprocessing.get_context("spawn")
    path.write_text("before")
    answers = spawn.Queue()
    one = spawn.Process(target=_fill, args=(kind, path, 20_000, answers))
    one.start()
    sentence = answers.get(timeout=60)
    one.join()
    assert sentence.startswith(f"'{path}' cannot be written: File too large, ") and "bytes are free" in sentence
    assert path.read_text() == "before"
    assert [one.name for one in tmp_path.iterdir()] == ["one.nc"]


def test_an_error_of_a_library_that_is_no_lack_of_room_keeps_its_words(tmp_path):
    with pytest.raises(NotWritten, match="one.nc' cannot be written: NetCDF: a riddle, "), whole(tmp_path / "one.nc"):
        raise RuntimeError("NetCDF: a riddle")


def test_the_name_of_an_unfinished_file_cannot_be_guessed(tmp_path):
    names = set()
    for _ in range(2):
        with whole(tmp_path / "one.html") as unfinished:
            names.add(unfinished.name)
            unfinished.write_text("x")
    assert len(names) == 2 and all(len(name) > len(".one.html..unfinished") + 12 for name in names)


def test_a_folder_that_cannot_be_is_refused_before_any_work(tmp_path):
    (tmp_path / "results").write_text("a file where a folder should be")
    with pytest.raises(NotWritten, match="results' cannot be made"):
        check_writable(tmp_path / "results" / "one.nc")
    with pytest.raises(NotWritten, match="is a folder, and the name of a file is needed"):
        check_writable(tmp_path)


def test_a_lack_of_room_is_told_with_folder_and_bytes(tmp_path, monkeypatch):
    (tmp_path / "full").mkdir()
    usage = {tmp_path: 10**9, tmp_path / "full": 4096}
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=usage[folder]))
    assert lack_of_room(tmp_path) == ""
    said = f"only 4,096 bytes are free in '{tmp_path / 'full'}': make room, and call again."
    assert lack_of_room(tmp_path, tmp_path / "full") == said
