"""The order of schemes on forces with kinks; the test computes the references."""

import numpy as np
import pytest

from reference.experiments.inelastic import inelastic
from study import io
from study.experiments.kinks import kinks
from study.marching.result import STATUSES_OR_NOT_RUN

OPTIONS = {
    "steps_per_period": [64, 256, 512, 1024, 2048, 4096],
    "steps_per_spacing": [2, 4, 8],
    "periods": 2,
    "samples_per_period": 8,
}


@pytest.fixture(scope="module")
def reference():
    return inelastic(["hardening", "yielding", "shaken"], 2, 8)


def test_a_kink_costs_the_order(reference, monkeypatch):
    """It alone makes the dataset, and measures the order of a force with memory and of a load with kinks."""
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    ds = kinks(["hardening", "yielding", "shaken"], ["average_acceleration", "gauss4", "energy_momentum"], **OPTIONS)
    smooth, yielding, shaken = ds.observed_order.sel(scheme="gauss4").values
    assert smooth == pytest.approx(4.0, abs=0.2) and yielding < 3.0 and shaken < 3.0
    assert ds.observed_order.sel(scheme="average_acceleration").values == pytest.approx(np.full(3, 2.0), abs=0.4)
    # the steps of a fourth-order method meet the kinks of a record if they divide its spacing
    dividing = ds.dividing_order.sel(problem="shaken", scheme=["average_acceleration", "gauss4"])
    assert dividing.values == pytest.approx([2.0, 4.0], abs=0.1)
    assert ds.dividing_sampled_error.sel(problem=["hardening", "yielding"]).isnull().all()
    # average acceleration balances the energies to round-off, although its error exceeds 1e-3
    blind = ds.sel(scheme="average_acceleration", problem="yielding").isel(steps_per_period=0)
    assert float(blind.sampled_error) > 1e-3 and float(blind.max_energy_imbalance) < 1e-12
    # the energy-momentum method takes its force from a potential, so it is left out if the force dissipates
    left_out = ds.sel(scheme="energy_momentum", problem="yielding")
    assert np.isnan(left_out.sampled_error).all() and (left_out.status == STATUSES_OR_NOT_RUN.index("not_run")).all()
    assert ((ds.status == 0) == ds.sampled_error.notnull()).all()
    assert np.isfinite(ds.sampled_error.sel(scheme="energy_momentum", problem="shaken")).all()
    # the hardening spring is stiffest at its start; before yielding, the other oscillators have a period of one second
    np.testing.assert_allclose(ds.highest_frequency, [10 * np.sqrt(1 + 30 * 1.5**2), 2 * np.pi, 2 * np.pi])
