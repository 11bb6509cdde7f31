"""Errors against step sizes, and flags where the reference is too coarse to resolve them."""

import numpy as np
import pytest

import study
from study import io
from study.experiments.accuracy import accuracy


def test_errors_below_the_uncertainty_of_the_reference_are_flagged(cosine, monkeypatch):
    """An uncertain displacement of the reference flags errors of the trajectory, but not errors of the energy."""
    reference = cosine
    doubts = {"u_uncertainty": 1e-3, "period_uncertainty": 1e-12, "energy_drift": 1e-15}
    reference = reference.assign(doubts)
    reference.attrs["source"] = io.SOURCE
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    linear = study.Problem(lambda u: (2 * np.pi) ** 2 * u, potential=lambda u: 2 * (np.pi * u) ** 2, u0=1.0)
    monkeypatch.setitem(study.problems._entries, "harmonic", linear)
    ds = accuracy(["harmonic"], ["average_acceleration", "rk4"], [8, 64, 512], [3]).squeeze(["problem", "periods"])
    doubt = ds.uncertainty.to_pandas()
    assert doubt["max_trajectory_error"] == pytest.approx(1e-3) and doubt["max_energy_error"] == pytest.approx(1e-13)
    assert doubt["phase_error"] == pytest.approx(1e-3 / (2 * np.pi), rel=1e-3)
    for measure in ds.measure.values:
        within = abs(ds[measure]) <= 10 * ds.uncertainty.sel(measure=measure)
        np.testing.assert_array_equal(ds.flagged.sel(measure=measure) == 1, within)
        np.testing.assert_array_equal(ds.flagged.sel(measure=measure) == 2, np.isnan(ds[measure]))
    trajectory = ds.flagged.sel(measure="max_trajectory_error", scheme="rk4")
    np.testing.assert_array_equal(trajectory, [0, 1, 1])
    assert (ds.flagged.sel(measure="max_energy_error", scheme="rk4") == 0).all()
