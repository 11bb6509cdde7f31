"""Reference solutions that experiments read."""

import pytest
import xarray as xr

from reference.experiments.amplitudes import amplitudes
from study import io
from tests.references import cosine


@pytest.fixture(name="cosine")
def _cosine() -> xr.Dataset:
    """Reference of cos(2πt), one period in 512 equal parts."""
    return cosine(8)


@pytest.fixture(scope="session")
def exact() -> xr.Dataset:
    """Exact periods and orbits over two decades of amplitude."""
    dataset = amplitudes(["hardening", "softening", "double_well"], {"first": -1.0, "last": 1.0, "count": 6})
    return dataset.assign_attrs(source=io.SOURCE)


@pytest.fixture
def springs(exact, tmp_path, monkeypatch):
    """The exact periods, also in the file that experiments read."""
    monkeypatch.chdir(tmp_path)
    io.write(exact, "results/reference/amplitudes.nc")
    return exact
