"""Collapse, drift and residual drift of a yielding mass with P-Δ."""

from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
import yaml

from study import settings
from study.experiments.what_moves import TRIED, _collapse_intensity, _Oscillators, what_moves


def test_collapse_is_found_and_failed_runs_are_no_collapses():
    least = np.array([2.0, 7.7, 1e9, 5.0])

    def collapses(intensities):
        outcomes = (intensities >= least).astype(float)
        outcomes[..., 3] = np.where(intensities[..., 3] > 4, np.nan, outcomes[..., 3])
        return outcomes

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


@pytest.mark.slow
def test_the_first_collapse_does_not_depend_on_the_intensities_tried():
    """Would catch too few intensities: those tried are others in units of another strength."""
    options = yaml.safe_load((Path(__file__).parents[2] / "config" / "study.yaml").read_text())["what_moves"]
    collapse = what_moves(**options | {"periods": [0.2]}).collapse_intensity
    ratio = collapse.sel(variant="strength") / collapse.sel(variant="reference")
    assert ratio.values == pytest.approx(0.9, rel=3e-3)


@pytest.mark.slow
def test_the_load_is_the_record_between_its_samples_and_zero_after_it():
    samples = np.random.default_rng(0).normal(size=(3, 5))
    load = _Oscillators("average_acceleration", samples, 0.1).problem(jnp.array(1.0), 2.0, 1.0, 0.05, 1.0).load
    times = np.array([0.0, 0.03, 0.1, 0.25, 0.399])
    expected = -2.0 * np.interp(times, 0.1 * np.arange(5), samples[1])
    assert [float(load(t)) for t in times] == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert float(load(0.41)) == 0


@pytest.mark.slow
def test_the_records_of_the_full_study_leave_the_march_one_native_loop():
    """Would catch a table that makes the runs of the full study take twice as long."""
    config = Path(__file__).parents[2] / "config"
    short, full = (yaml.safe_load((config / f"{name}.yaml").read_text())["what_moves"] for name in ("study", "full"))
    full = short | full
    oscillators = _Oscillators("average_acceleration", np.zeros((1, 8)), 0.01)
    samples = oscillators.problem(jnp.array(0.0), 1.0, 1.0, 0.05, 1.0).load.samples
    each = samples.nbytes / samples.size
    assert each * full["records"] * (full["duration"] / 0.01 + 1) < 0.9 * settings._THRESHOLD
