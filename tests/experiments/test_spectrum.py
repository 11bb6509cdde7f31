"""Steps for the peak drift under a record, from a reference that the test makes itself."""

import numpy as np
import pytest

import study
from reference.experiments.spectrum import spectrum as exact
from study import io
from study.experiments.spectrum import spectrum
from study.problem.inelastic import yielding_under_record

PERIODS, REDUCTIONS, DURATION = [0.2, 1.0], [1.0, 4.0], 5.0


@pytest.fixture(scope="module")
def reference():
    return exact(PERIODS, REDUCTIONS, DURATION)


def test_the_exact_peaks_are_those_of_fine_steps(reference):
    assert float((reference.peak_drift_uncertainty / reference.peak_drift).max()) < 1e-12
    for period in PERIODS:
        for reduction in REDUCTIONS:
            known = reference.sel(period=period, reduction=reduction)
            problem = yielding_under_record(period, float(known.yield_force))
            peak = study.Quantity(lambda u: u, name="peak", reduce="peak")
            fine = study.run(problem, "rk4", dt=2e-4, steps=25_000, observe=[peak]).peak
            np.testing.assert_allclose(fine, known.peak_drift, rtol=1e-5)
    assert (reference.ductility.sel(reduction=1) == 1).all() and (reference.ductility.sel(reduction=4) > 1).all()


def test_the_step_that_is_needed_keeps_the_error_as_all_finer_ones(reference, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    schemes, steps = ["average_acceleration", "energy_momentum"], [0.1, 0.05, 0.02, 0.01, 0.005, 0.0025, 0.00125]
    ds = spectrum(PERIODS, REDUCTIONS, DURATION, schemes, steps, 0.01)
    assert ds.step_needed.sel(scheme="energy_momentum").isnull().all()  # the force dissipates
    ours = ds.sel(scheme="average_acceleration")
    assert ours.step_needed.notnull().all()
    fine = ours.step_size <= ours.step_needed
    assert (ours.error.where(fine, 0) <= 0.01).all()
    # the next coarser one does not
    next_coarser = np.maximum(fine.argmax("step_size") - 1, 0)
    assert ((ours.error.isel(step_size=next_coarser) > 0.01) | fine.isel(step_size=0)).all()
    # the error falls with the square of the step once the record is resolved
    ratio = ours.error.sel(step_size=0.01) / ours.error.sel(step_size=0.00125)
    assert float(ratio.median()) > 10
