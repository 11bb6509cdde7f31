"""Collapse, drift and residual drift of a yielding mass with P-Δ."""

import numpy as np
import pytest

from study.experiments.what_moves import TRIED, _collapse_intensity, what_moves


def test_collapse_is_found_and_failed_runs_are_no_collapses():
    least = np.array([2.0, 7.7, 1e9, 5.0])

    def collapses(intensities):
        found = (intensities >= least).astype(float)
        found[..., 3] = np.where(intensities[..., 3] > 4, np.nan, found[..., 3])
        return found

    intensity, failed = _collapse_intensity(collapses, least.shape)
    assert intensity[:2] == pytest.approx(least[:2], rel=2e-3)
    assert np.isnan(intensity[2:]).all() and failed.tolist() == [0, 0, 0, (TRIED > 4).sum()]
    assert least[2] > TRIED[-1]


def test_collapse_scales_with_strength():
    """Would catch an intensity that is not the elastic force over the strength, and lanes that are mixed up."""
    ds = what_moves("average_acceleration", 2, 0.02, 3.0, [0.5], 3.0, 1)
    assert int(ds.failed.sum()) == 0 and int(ds.runs) > 2 * 7
    collapse = ds.collapse_intensity.isel(period=0)
    # strength and intensity enter the equations by their ratio alone
    assert (collapse.sel(variant="strength") / collapse.sel(variant="reference")).values == pytest.approx(0.9, rel=3e-3)
    # the reference takes the step of the variant "spacing" here
    for name in ("collapse_intensity", "peak_drift", "residual_drift"):
        assert ds[name].sel(variant="spacing").values == pytest.approx(ds[name].sel(variant="reference").values)
    assert (ds.residual_drift < ds.peak_drift).all()
    # at the collapse the static force of the yielding spring, less the P-Δ effect, vanishes
    static = ds.hardening * ds.collapse + (1 - ds.hardening) - ds.p_delta * ds.collapse
    assert static.item() == pytest.approx(0, abs=1e-12) and 0 < ds.hardening < ds.p_delta
