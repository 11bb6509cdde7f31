"""Step sizes that keep the error of the peak drift under records; the test computes the reference."""

import numpy as np
import pytest
import xarray as xr

import study
from reference.experiments.spectrum import spectrum as exact
from study import io
from study.mechanics.ground import GroundMotion
from study.observer.peak import Peak
from study.problem.inelastic import SPACING, yielding_under_record
from study.runs.needs import needs
from study.runs.records import RATIO, as_runs, spectrum, steps_tried

RECORDS, PERIODS, REDUCTIONS, DURATION = 2, [0.2, 1.0], [1.0, 4.0], 5.0


@pytest.fixture(scope="module")
def reference():
    return exact(RECORDS, PERIODS, REDUCTIONS, DURATION)


def _peak(known, scheme, dt):
    """Peak drift of a single run."""
    ground = GroundMotion(known.ground.values, SPACING)
    problem = yielding_under_record(ground, float(known.period), float(known.yield_force))
    return study.run(problem, scheme, dt=dt, steps=int(np.ceil(DURATION / dt)), observe=[Peak()]).peak


def test_the_exact_peaks_are_those_of_fine_steps(reference):
    assert float((reference.peak_drift_uncertainty / reference.peak_drift).max()) < 1e-9
    for known in (reference.isel(record=1, period=p, reduction=r) for p in (0, 1) for r in (0, 1)):
        np.testing.assert_allclose(_peak(known, "rk4", SPACING / 100), known.peak_drift, rtol=1e-6)
    assert (reference.ductility.sel(reduction=1) == 1).all() and (reference.ductility.sel(reduction=4) > 1).all()


def test_steps_lie_close_together_and_commensurate_ones_are_whole_parts_and_multiples():
    steps, commensurate = steps_tried(0.05, 0.004)
    assert steps[0] == pytest.approx(0.05) and steps[-1] == pytest.approx(0.004)
    assert (steps[:-1] / steps[1:]).max() <= RATIO + 1e-9 and (steps[:-1] / steps[1:]).min() > 1 + 1e-6
    np.testing.assert_allclose(steps[commensurate], [0.04, 0.02, 0.01, 0.02 / 3, 0.005, 0.004])


@pytest.fixture
def ds(reference, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    schemes = ["average_acceleration", "energy_momentum"]
    return spectrum(RECORDS, PERIODS, REDUCTIONS, DURATION, schemes, 0.1, 0.0025, 0.01)[0]


@pytest.mark.slow
def test_the_step_that_is_needed_keeps_the_error_as_all_finer_ones(ds):
    assert ds.largest_step_size.sel(scheme="energy_momentum").isnull().all()  # the force dissipates
    ours = ds.sel(scheme="average_acceleration")
    assert ours.largest_step_size.notnull().all() and (ours.factorisations_per_step >= 1).all()
    for condition, some in (("any_step", ours), ("practice", ours.isel(step_size=np.flatnonzero(ours.divides)))):
        fine = some.step_size <= some.largest_step_size.sel(condition=condition)
        assert (some.peak_drift_error.where(fine, 0) <= 0.01).all()
        # the next coarser step does not keep the error
        next_coarser = np.maximum(fine.argmax("step_size") - 1, 0)
        assert ((some.peak_drift_error.isel(step_size=next_coarser) > 0.01) | fine.isel(step_size=0)).all()
    # the error falls with the square of the step once the record is resolved
    ratio = ours.peak_drift_error.sel(step_size=0.02, method="nearest") / ours.peak_drift_error.sel(
        step_size=0.0025, method="nearest"
    )
    assert float(ratio.median()) > 10


def test_a_lane_is_the_run_of_its_record_period_and_strength(ds, reference):
    ours = ds.sel(scheme="average_acceleration").isel(step_size=7)
    for at in ({"record": 0, "period": 1, "reduction": 0}, {"record": 1, "period": 0, "reduction": 1}):
        known = reference.isel(at)
        alone = _peak(known, "average_acceleration", float(ours.step_size))
        np.testing.assert_allclose(abs(alone / known.peak_drift - 1), ours.peak_drift_error.isel(at), rtol=1e-9)


def test_records_take_the_place_of_starts():
    """Two schemes, three step sizes and two records of 20 s; the second scheme refuses the oscillators."""
    error = np.full((2, 3, 2, 2, 1), np.nan)
    error[0] = np.array([0.5, 0.02, 0.001])[:, None, None, None]
    error[0, 1, 1, 0, 0] = 0.05  # the largest over records and periods decides
    error[0, 0, 1, 0, 0] = np.nan  # a run that failed
    along = ("scheme", "step_size", "record", "period", "reduction")
    spectrum = xr.Dataset(
        {
            "peak_drift_error": (along, error),
            "status": (along, np.where(np.isnan(error), [[[[[1]]]], [[[[4]]]]], 0)),
            "force_evaluations_per_step": (along, np.where(np.isnan(error), np.nan, 2.0), {"long_name": "per step"}),
            "tangent_evaluations_per_step": (along, 0 * error),
            "factorisations_per_step": (along, 0 * error),
        },
        {
            "scheme": ["rk4", "energy_momentum"],
            "step_size": [0.1, 0.03, 0.02],
            "divides": ("step_size", [0, 0, 1]),
            "period": [0.2, 1.0],
            "duration": 20.0,
            "damping_ratio": 0.05,
            "spacing": 0.02,
        },
    )
    runs = as_runs(spectrum, 1e-4)
    assert runs.tried.transpose("scheme", "size").values.tolist() == [[1, 1, 1], [0, 0, 0]]
    assert runs.status.transpose("scheme", "size", "periods").values.tolist() == [[[1], [0], [0]], [[4], [4], [4]]]
    assert (runs.starts, runs.decided, runs.time_scale) == (4, 100, 0.2)
    assert runs.force_evaluations.attrs == {"long_name": "internal forces evaluated", "units": "1"}
    needed = needs(runs, [0.1, 0.01]).sel(quantity="peak drift", scheme="rk4")
    free, practice = (needed.sel(condition=name) for name in ("any_step", "practice"))
    assert free.step_size.values.tolist() == [0.03, 0.02] and practice.step_size.values.tolist() == [0.02, 0.02]
    assert free.divides.values.tolist() == [0, 1] and practice.divides.values.tolist() == [1, 1]
    assert (free.error[0], free.largest_error[0]) == (0.02, 0.05)
    assert free.force_evaluations[0] == 2 * free.duration / 0.03
