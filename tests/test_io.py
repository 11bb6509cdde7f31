"""Files are complete or absent, have the same bytes for the same data, and are refused with a sentence if damaged."""

import multiprocessing
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import study
from study import io

#: Seconds for which writers and readers work concurrently.
MEETING = 3.0


@pytest.fixture
def dataset():
    """A run with attributes like those of the datasets of experiments."""
    ds = study.run("hardening", "rk4", dt=0.0075, steps=2000)
    ds.attrs = io.provenance("A test", "the tests")
    return ds


def test_round_trip_with_everything_a_stranger_needs(dataset, tmp_path):
    io.write(dataset, tmp_path / "one.nc")
    back = study.open_dataset("one", tmp_path)
    xr.testing.assert_identical(back, dataset)
    assert {"title", "source", "references", "history", "commit", "packages"} <= set(back.attrs)
    assert "jax" in back.attrs["packages"]


def test_flags_that_are_missing_somewhere_stay_integers_in_the_file(tmp_path):
    flagged = xr.Dataset({"status": ("x", np.array([0, 1], np.int32), io.flags("status", ["a", "b"], np.int32))})
    merged = xr.merge([flagged.assign_coords(x=[0, 1]), xr.Dataset({"y": ("x", [1.0])}, {"x": [2]})], join="outer")
    io.write(merged.assign_attrs(source=io.SOURCE), tmp_path / "one.nc")
    packed = xr.open_dataset(tmp_path / "one.nc", mask_and_scale=False)
    assert packed.status.dtype == packed.status.flag_values.dtype == np.int32
    packed.close()
    np.testing.assert_array_equal(io.read(tmp_path / "one.nc").status, [0, 1, np.nan])


def test_the_same_bytes_twice(dataset, tmp_path):
    for name in ("one.nc", "two.nc"):
        io.write(dataset, tmp_path / name)
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()


def test_an_interrupted_write_leaves_what_was_there(dataset, tmp_path, monkeypatch):
    path = tmp_path / "one.nc"
    io.write(dataset, path)
    before = path.read_bytes()

    def interrupted(self, target, **options):
        target.write_bytes(before[:100])
        raise KeyboardInterrupt

    monkeypatch.setattr(xr.Dataset, "to_netcdf", interrupted)
    with pytest.raises(KeyboardInterrupt):
        io.write(dataset, path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["one.nc"]


def _dataset(value: float) -> xr.Dataset:
    values = np.random.default_rng(int(value)).random(20_000)
    values[0] = value
    return xr.Dataset({"x": ("i", values)}, attrs={"source": io.SOURCE})


def _write(path: Path, value: int, failures) -> None:
    end = time.monotonic() + MEETING
    while time.monotonic() < end:
        try:
            io.write(_dataset(value), path)
        except Exception as error:
            failures.put(f"writer {value}: {error!r}")


def _read(path: Path, failures, reads) -> None:
    end = time.monotonic() + MEETING
    while time.monotonic() < end:
        try:
            value = io.read(path).x.values[0]
            assert value in (1, 2), value
            reads.put(value)
        except Exception as error:
            failures.put(f"reader: {error!r}")


@pytest.mark.slow
def test_two_writers_and_three_readers_never_meet_half_a_file(tmp_path):
    """A dataset that a reader can open while it is written."""
    path, spawn = tmp_path / "one.nc", multiprocessing.get_context("spawn")
    io.write(_dataset(1), path)
    failures, reads = spawn.Queue(), spawn.Queue()
    people = [spawn.Process(target=_write, args=(path, value, failures)) for value in (1, 2)]
    people += [spawn.Process(target=_read, args=(path, failures, reads)) for _ in range(3)]
    for process in people:
        process.start()
    # a process ends only after its queues are read
    seen: set[int] = set()
    failed: set[str] = set()
    while any(process.is_alive() for process in people):
        for queue, values in ((reads, seen), (failures, failed)):
            while not queue.empty():
                values.add(queue.get())
        time.sleep(0.01)
    assert not failed
    assert seen == {1, 2}
    assert [file.name for file in tmp_path.iterdir()] == ["one.nc"]


def _fill(content, path: Path, answers) -> None:
    """Write past a limit on the size of files, which acts like a full disk, and pass on the message of the error."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
    with pytest.raises(io.NotWritten) as caught:
        io.write(content, path)
    answers.put(str(caught.value))


@pytest.mark.skipif(sys.platform == "win32", reason="limits of files are those of POSIX")
@pytest.mark.parametrize("content", [_dataset(2), "x" * 1_000_000], ids=["dataset", "page"])
def test_a_file_that_does_not_fit_is_refused_in_a_sentence_and_leaves_what_was_there(tmp_path, content):
    path, spawn = tmp_path / "one.nc", multiprocessing.get_context("spawn")
    path.write_text("before")
    answers = spawn.Queue()
    process = spawn.Process(target=_fill, args=(content, path, answers))
    process.start()
    sentence = answers.get(timeout=60)
    process.join()
    assert sentence.startswith(f"'{path}' cannot be written: ") and sentence.endswith(" bytes are free.")
    assert path.read_text() == "before"
    assert [file.name for file in tmp_path.iterdir()] == ["one.nc"]


def test_a_file_that_cannot_be_is_refused_before_any_work(tmp_path):
    (tmp_path / "results").write_text("a file where a folder should be")
    with pytest.raises(io.NotWritten, match="results/one.nc' cannot be written: File exists"):
        io.check_writable(tmp_path / "results" / "one.nc")
    with pytest.raises(io.NotWritten, match="cannot be written: it is a folder"):
        io.check_writable(tmp_path)


def test_a_missing_dataset_says_what_to_run(dataset, tmp_path):
    with pytest.raises(FileNotFoundError, match="is made by `snakemake .*energy_error.nc` in"):
        study.open_dataset("energy_error", tmp_path)
    io.write(dataset, tmp_path / "energy_error.nc")
    with pytest.raises(FileNotFoundError, match="needs.nc': .* by `snakemake .*needs.nc` in"):
        study.recommend("hardening", allowed_error=0.01, folder=tmp_path)
    with pytest.raises(FileNotFoundError, match="may mean 'energy_error', another folder .* by `snakemake"):
        study.open_dataset("energy_eror", tmp_path)


def test_a_file_in_place_of_a_name_is_refused(tmp_path):
    with pytest.raises(ValueError, match="takes a name such as 'accuracy' .*, not the file 'results/accuracy.nc'"):
        study.open_dataset("results/accuracy.nc")


@pytest.mark.parametrize(
    "name, content, reason",
    [
        ("one.nc", None, "there is no file '"),
        ("one.nc", b"", "it is empty: move it away, and `snakemake "),
        ("one.nc", b"CDF?", "it is damaged or not a .nc file "),
        ("one.csv", b"\xff\xfe\x00a,b\n", "it is damaged or not a .csv file "),
        ("one.json", b"{", "it is damaged or not a .json file "),
        ("one.pdf", b"%PDF-1.7 half", "it is damaged or not a .pdf file "),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_with_the_command_that_makes_it(tmp_path, name, content, reason):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(io.NotRead) as caught:
        io.read(path)
    assert reason in str(caught.value) and f"`snakemake {path}` makes" in str(caught.value)


def test_half_a_dataset_and_a_foreign_one_are_refused(dataset, tmp_path):
    io.write(dataset, tmp_path / "one.nc")
    (tmp_path / "one.nc").write_bytes((tmp_path / "one.nc").read_bytes()[:2000])
    with pytest.raises(
        ValueError, match="one.nc' cannot be used, because it is damaged or not a .nc file .* `snakemake"
    ):
        study.open_dataset("one", tmp_path)
    xr.Dataset({"x": ("y", np.arange(3))}).to_netcdf(tmp_path / "two.nc")
    with pytest.raises(ValueError, match="was not written by this study"):
        study.open_dataset("two", tmp_path)


def test_tables_are_read_as_texts(tmp_path):
    io.write('a,b\n1.0,""\n', tmp_path / "claims.csv")
    assert io.read(tmp_path / "claims.csv").to_dict("records") == [{"a": "1.0", "b": ""}]


@pytest.mark.slow
@pytest.mark.parametrize("damage", [lambda path: path.unlink(), lambda path: path.write_bytes(b"CDF")])
def test_parts_that_cannot_be_read_are_not_gathered(dataset, tmp_path, damage):
    parts = [tmp_path / "one.nc", tmp_path / "two.nc"]
    for path in parts:
        io.write(dataset, path)
    damage(parts[1])
    done = subprocess.run(
        [sys.executable, "-m", "pipeline.gather", tmp_path / "whole.nc", "lane", *parts],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "two.nc" in done.stderr
    assert not (tmp_path / "whole.nc").exists()


def test_files_opened_together_give_any_selection_of_their_rows(tmp_path):
    values = np.arange(30.0).reshape(10, 3)
    whole = xr.Dataset({"u": (("lane", "t"), values, {"units": "m"})}, {"lane": np.arange(10), "t": [0.0, 0.5, 1.0]})
    for k, rows in enumerate((slice(4), slice(4, 5), slice(5, 10))):
        io.write(whole.isel(lane=rows), tmp_path / f"{k}.nc")
    joined = io.opened_together([io.opened(tmp_path / f"{k}.nc") for k in range(3)], "lane")
    for chosen in (7, -1, [8, 0, 5, 0], slice(None, None, -2), slice(3, 3), slice(2, 6)):
        xr.testing.assert_identical(joined.isel(lane=chosen), whole.isel(lane=chosen))
        xr.testing.assert_identical(joined.isel(lane=chosen, t=[2, 0]), whole.isel(lane=chosen, t=[2, 0]))
    xr.testing.assert_identical(joined.load(), whole)
