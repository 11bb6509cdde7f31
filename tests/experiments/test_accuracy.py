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
    growth = {"steps_per_period": [64], "periods": [3, 30], "known": 3, "extrapolated": 30, "allowed_error": 0.02}
    ds, longer = accuracy(["harmonic"], ["average_acceleration", "rk4"], [8, 64, 512], [3], growth)
    ds = ds.squeeze(["problem", "periods"])
    doubt = ds.uncertainty.to_pandas()
    assert doubt["displacement_error"] == pytest.approx(1e-3) and doubt["max_energy_error"] == pytest.approx(1e-15)
    assert doubt["phase_error"] == pytest.approx(1e-3 / (2 * np.pi), rel=1e-3)
    for measure in ds.measure.values:
        within = abs(ds[measure]) <= 10 * ds.uncertainty.sel(measure=measure)
        np.testing.assert_array_equal(ds.flagged.sel(measure=measure) == 1, within)
        np.testing.assert_array_equal(ds.flagged.sel(measure=measure) == 2, np.isnan(ds[measure]))
    trajectory = ds.flagged.sel(measure="displacement_error", scheme="rk4")
    np.testing.assert_array_equal(trajectory, [0, 1, 1])
    assert (ds.flagged.sel(measure="max_energy_error", scheme="rk4") == 0).all()
    # after n periods average acceleration is n (ωΔt)²/12 periods late, and its displacement wrong by 2π times that
    late = longer.phase_error.sel(scheme="average_acceleration").squeeze()
    np.testing.assert_allclose(late, (longer.periods - 1 / 4) * (2 * np.pi / 64) ** 2 / 12, rtol=0.01)
    assert longer.fewest_steps_per_period.values.tolist() == [[64, 64]]
    assert longer.extrapolated_steps_per_period.values.tolist() == [[512, 512]]
    assert longer.extrapolated_error[0, 0] == pytest.approx(2 * np.pi * 30 * (2 * np.pi / 512) ** 2 / 12, rel=0.02)
    assert longer.order_of_loss.values.tolist() == [np.inf, 5] and longer.exponent.values.tolist() == [1 / 2, 2 / 5]
