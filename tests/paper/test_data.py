"""Files that are no datasets of the study are refused with one sentence."""

import pandas as pd
import pytest
import xarray as xr

from paper.data import SOURCE, load, load_table
from study import datasets


def test_the_study_signs_its_datasets_so():
    assert SOURCE == datasets.SOURCE


def test_a_dataset_of_the_study_is_read(tmp_path):
    xr.Dataset({"u": ("t", [1.0])}, attrs={"source": SOURCE}).to_netcdf(tmp_path / "own.nc")
    assert load(tmp_path / "own.nc").u.item() == 1


@pytest.mark.parametrize(
    "content, sentence",
    [(None, "There is no file"), (b"", "is empty"), (b"CDF?", "is damaged or no netCDF file")],
)
def test_no_dataset(tmp_path, content, sentence):
    path = tmp_path / "some.nc"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SystemExit, match=sentence):
        load(path)


def test_a_foreign_dataset_is_refused(tmp_path):
    xr.Dataset({"u": ("t", [1.0])}).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(SystemExit, match="cannot be used, it is not of this study"):
        load(tmp_path / "foreign.nc")


def test_tables_are_read_as_texts(tmp_path):
    path = tmp_path / "claims.csv"
    with pytest.raises(SystemExit, match="There is no file"):
        load_table(path)
    path.write_bytes(b"\xff\xfe\x00a,b\n")
    with pytest.raises(SystemExit, match="damaged or no CSV file"):
        load_table(path)
    pd.DataFrame({"a": ["1.0", ""]}).to_csv(path, index=False)
    path.write_text('a,b\n1.0,""\n')
    assert load_table(path).to_dict("records") == [{"a": "1.0", "b": ""}]
