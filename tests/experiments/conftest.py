"""Reference solutions that experiments read."""

import numpy as np
import pytest
import xarray as xr

from reference.experiments.amplitudes import amplitudes
from study import io


@pytest.fixture
def cosine() -> xr.Dataset:
    """Reference dataset of cos(2πt), in the format of the pipeline."""
    phase = np.linspace(0, 1, 64 * 8 + 1)
    return xr.Dataset(
        {
            "u": ("t", np.cos(2 * np.pi * phase)),
            "v": ("t", -2 * np.pi * np.sin(2 * np.pi * phase)),
            "period": 1.0,
            "period_remainder": 0.0,
        },
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "harmonic"},
    )


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
