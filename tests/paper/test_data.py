"""How datasets are read: files that are none are refused with one sentence, and errors that mean nothing left out."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from paper.data import SOURCE, load, load_table, loss_of_amplitude, of_kinds
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


def test_a_ripple_of_the_amplitude_is_no_loss():
    """A loss per period does not depend on the length of the run; a ripple is divided by it."""
    steps = np.array([8, 16, 32, 64, 128, 256, 512])
    loss = 1.0 / steps**3
    ripple = np.array([3.0, -2.0, 1.0, -1.0, 0.5, 0.3, 0.2])
    late = np.where(steps < 30, 0.1, 1.0) * loss  # saturated at large steps
    per_period = np.stack([np.outer(loss, [1, 1]), np.outer(ripple, [1 / 3, 1 / 100]), np.stack([loss, late], 1)])
    errors = xr.Dataset(
        {"amplitude_decay": (("scheme", "steps_per_period", "periods"), per_period)},
        {"steps_per_period": steps, "periods": [3, 100]},
    )
    found = loss_of_amplitude(errors, 3, 100).values
    np.testing.assert_allclose(found[0], loss)
    assert np.isnan(found[1]).all()
    np.testing.assert_array_equal(np.isnan(found[2]), steps < 30)


def test_chosen_schemes_come_in_the_order_of_the_choice_or_the_first_ones_stand_in():
    dataset = xr.Dataset(coords={"scheme": ["a", "b", "c"]})
    assert of_kinds(dataset, ["c", "x", "a"]).scheme.values.tolist() == ["c", "a"]
    assert of_kinds(dataset, ["x", "y"]).scheme.values.tolist() == ["a", "b"]
