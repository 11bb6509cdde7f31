"""Errors of steps under records, measured and predicted; the test computes the reference."""

import numpy as np
import pytest
import scipy.integrate
import scipy.signal

import study
from reference.experiments.record_error import record_error as exact
from study import io
from study.experiments import record_error as experiment
from study.problem.inelastic import yielding_under_record
from study.problem.records import family

RECORDS = {"spacings": [0.02], "corners": [0.5], "kappas": [0.02], "seeds": 1, "duration": 3.0}


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """The options of the records, with a folder that holds two of another length and spacing."""
    folder = tmp_path_factory.mktemp("records")
    for seed, dt in enumerate((0.01, 0.02)):
        t = dt * np.arange(round(4 / dt) + 1 + 7 * seed)
        a = np.random.default_rng(seed).standard_normal(len(t))
        np.savetxt(folder / f"own_{seed}.csv", np.stack([t, a], axis=1), header="t (s), a (m/s2)", delimiter=",")
    return RECORDS | {"folder": str(folder)}


@pytest.fixture(scope="module")
def reference(records):
    return exact(**records, periods=[0.5, 1.0], reduction=3)


def test_motions_under_records_of_a_folder_are_exact(reference, records):
    grounds = family(**records)[22:]
    assert reference.record.values[22:].tolist() == [ground.title for ground in grounds] == ["own_0", "own_1"]
    for record, ground in enumerate(grounds, start=22):
        omega, samples = 2 * np.pi, np.asarray(ground.acceleration)
        matrices = [[0, 1], [-(omega**2), -0.1 * omega]], [[0], [-1]], [[1, 0]], [[0]]
        _, u, _ = scipy.signal.lsim(matrices, samples, ground.kinks)
        motion = reference.u.isel(record=record).sel(period=1.0).values
        assert motion[: len(u)] == pytest.approx(u.ravel(), abs=1e-12) and np.isnan(motion[len(u) :]).all()


def test_errors_are_those_of_single_runs(reference, records, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    ds = experiment.record_error(["average_acceleration"]).isel(scheme=0)
    grounds = family(**records)
    for record, ratio in ((4, 0.5), (21, 0.75), (22, 0.75)):
        at, ground = {"record": record, "period": 1}, grounds[record]
        ours, known = ds.isel(at).sel(ratio=ratio), reference.isel(at)
        dt = ratio * ground.dt
        run = {"dt": dt, "steps": int(np.ceil(ground.duration / dt - 1e-9))}
        linear, yielding = (
            study.run(
                yielding_under_record(ground, 1.0, force),
                "average_acceleration",
                observe=["trajectory", "peak"],
                **run,
            )
            for force in (1e9, known.yield_force.item())
        )
        stride, known_stride = {0.5: (2, 1), 0.75: (4, 3)}[ratio]
        there = known.u.values[np.isfinite(known.u)][::known_stride]
        met = linear.u.values[::stride][: len(there)]
        error = np.abs(met - there[: len(met)]).max() / known.peak_drift.values[0]
        assert ours.error.sel(load="samples").item() == pytest.approx(error, rel=1e-6)
        peaks = np.abs([linear.peak.item(), yielding.peak.item()] / known.peak_drift.values - 1)
        assert ours.peak_error.values == pytest.approx(peaks, rel=1e-6)
    assert (ds.load_error.where(ds.divides == 1).fillna(0) < 1e-9).all()
    ratio = ds.error.sel(load="samples") / ds.predicted_error
    assert 0.95 < ratio.median() and ratio.max() < 1.01
    # the mean of the load leaves the error of the period at steps that pass over samples
    far = (ds.load_error > 10 * ds.period_error) & (ds.ratio < 1)
    assert (ds.error.sel(load="averages") < ds.error.sel(load="samples") / 3).where(far, True).mean() > 0.9


def test_means_over_a_step_are_integrals_of_the_record():
    ground = study.GroundMotion(np.array([0.0, 2.0, -1.0, 3.0, 1.0]), 0.1)
    means = experiment.averaged(ground, 0.15)
    for n, mean in enumerate(means):
        ends = max(0.15 * n - 0.075, 0.0), min(0.15 * n + 0.075, 0.4)
        t = np.linspace(*ends, 20_001)
        acceleration = np.interp(t, ground.kinks, ground.acceleration)
        # at t = 0 the motion has half a step, and after the record the acceleration is zero
        length = 0.15 if n else 0.075
        assert mean == pytest.approx(scipy.integrate.trapezoid(acceleration, t) / length, abs=1e-6)
