"""Datasets: whole or not at all, the same bytes for the same data, and a sentence when one cannot be opened."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import study
from study import datasets


@pytest.fixture
def dataset():
    """A dataset as the experiments make them."""
    ds = study.run("hardening", "rk4", dt=0.0075, steps=2000)
    ds.attrs = datasets.provenance("A test", "the tests")
    return ds


def test_round_trip_with_everything_a_stranger_needs(dataset, tmp_path):
    datasets.write(dataset, tmp_path / "one.nc")
    back = study.open("one", tmp_path)
    xr.testing.assert_identical(back, dataset)
    assert {"title", "source", "references", "history", "commit", "packages"} <= set(back.attrs)
    assert "jax" in back.attrs["packages"]


def test_flags_that_are_missing_somewhere_stay_integers_in_the_file(tmp_path):
    flagged = xr.Dataset({"status": ("x", np.array([0, 1], np.int32), datasets.flags("status", ["a", "b"], np.int32))})
    merged = xr.merge([flagged.assign_coords(x=[0, 1]), xr.Dataset({"y": ("x", [1.0])}, {"x": [2]})], join="outer")
    datasets.write(merged.assign_attrs(source=datasets.SOURCE), tmp_path / "one.nc")
    packed = xr.open_dataset(tmp_path / "one.nc", mask_and_scale=False)
    assert packed.status.dtype == packed.status.flag_values.dtype == np.int32
    packed.close()
    np.testing.assert_array_equal(datasets.read(tmp_path / "one.nc").status, [0, 1, np.nan])


def test_the_same_bytes_twice(dataset, tmp_path):
    for name in ("one.nc", "two.nc"):
        datasets.write(dataset, tmp_path / name)
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()


def test_an_interrupted_write_leaves_what_was_there(dataset, tmp_path, monkeypatch):
    path = tmp_path / "one.nc"
    datasets.write(dataset, path)
    before = path.read_bytes()

    def interrupted(self, target, **options):
        target.write_bytes(before[:100])
        raise KeyboardInterrupt

    monkeypatch.setattr(xr.Dataset, "to_netcdf", interrupted)
    with pytest.raises(KeyboardInterrupt):
        datasets.write(dataset, path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["one.nc"]


def test_a_dataset_is_renamed_into_place(dataset, tmp_path, monkeypatch):
    """A reader that has opened the former file reads on, and no reader sees half of the new one."""
    path, written = tmp_path / "one.nc", []
    datasets.write(dataset, path)
    before, to_netcdf = path.read_bytes(), xr.Dataset.to_netcdf

    def watched(self, target, **options):
        to_netcdf(self, target, **options)
        written.append(target.stat().st_ino)

    monkeypatch.setattr(xr.Dataset, "to_netcdf", watched)
    with path.open("rb") as reader:
        datasets.write(dataset.isel(t=slice(10)), path)
        assert reader.read() == before
    assert written == [path.stat().st_ino] and path.read_bytes() != before


def test_a_missing_dataset_says_what_to_run(dataset, tmp_path):
    with pytest.raises(FileNotFoundError, match="`snakemake .*energy_error.nc` makes"):
        study.open("energy_error", tmp_path)
    datasets.write(dataset, tmp_path / "energy_error.nc")
    with pytest.raises(FileNotFoundError, match="work_precision.nc'; `snakemake .*work_precision.nc` makes"):
        study.recommend("hardening", error=0.01, folder=tmp_path)
    with pytest.raises(FileNotFoundError, match="did you mean 'energy_error'[?] If not, `snakemake"):
        study.open("energy_eror", tmp_path)


@pytest.mark.parametrize(
    "file, folder, call",
    [
        ("results/accuracy.nc", "results", "study.open('accuracy')"),
        ("accuracy.nc", "results", "study.open('accuracy')"),
        ("results/reference/softening.nc", "results", "study.open('reference/softening')"),
        ("elsewhere/accuracy.nc", "results", "study.open('accuracy', folder='elsewhere')"),
        ("accuracy.nc", "elsewhere", "study.open('accuracy', folder='elsewhere')"),
    ],
)
def test_a_path_in_place_of_a_name_is_told_the_right_call(file, folder, call):
    with pytest.raises(ValueError) as caught:
        study.open(file, folder)
    assert str(caught.value) == f"study.open takes the name of a dataset, not its file: {call}."


def test_a_truncated_dataset_is_refused(dataset, tmp_path):
    path = tmp_path / "one.nc"
    datasets.write(dataset, path)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(ValueError, match="one.nc' cannot be used, it is damaged or no netCDF file .* `snakemake"):
        study.open("one", tmp_path)


@pytest.mark.parametrize("damage", [lambda path: path.unlink(), lambda path: path.write_bytes(b"CDF")])
def test_parts_that_cannot_be_read_are_not_gathered(dataset, tmp_path, damage):
    parts = [tmp_path / "one.nc", tmp_path / "two.nc"]
    for path in parts:
        datasets.write(dataset, path)
    damage(parts[1])
    done = subprocess.run(
        [sys.executable, "-m", "study.pipeline.gather", tmp_path / "whole.nc", "lane", *parts],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "two.nc" in done.stderr
    assert not (tmp_path / "whole.nc").exists()


def test_a_foreign_dataset_is_refused(tmp_path):
    xr.Dataset({"x": ("y", np.arange(3))}).to_netcdf(tmp_path / "one.nc")
    with pytest.raises(ValueError, match="was not written by this study"):
        study.open("one", tmp_path)
