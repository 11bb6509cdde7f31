"""Errors over long times and their laws of growth."""

import numpy as np
import pytest
import xarray as xr

import study
from study.experiments import long_runs as experiment
from study.experiments.long_runs import ARITHMETIC, BITS, long_runs
from study.experiments.long_times import growth, summary

OMEGA = 2 * np.pi


HARMONIC = study.Problem(lambda u: OMEGA**2 * u, potential=lambda u: OMEGA**2 * u * u / 2, u0=1.0, title="harmonic")


def _period(scheme, dt):
    """Period of the scheme on the harmonic oscillator, by linear theory."""
    half = OMEGA * dt / 2
    return np.pi * dt / {"average_acceleration": np.arctan, "central_difference": np.arcsin}[scheme](half)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5])
def test_a_law_of_growth_is_recovered_with_its_error(exponent):
    periods = np.array([1, 3, 10, 32, 100, 316, 1000])
    values = np.random.default_rng(0).normal(size=(2, 7, 64)) * periods[:, None] ** exponent
    found, error = growth(periods, values)
    assert np.all(np.abs(found - exponent) < 4 * error) and np.all((0.01 < error) & (error < 0.1))
    # without scatter between runs the exponent is exact
    found, error = growth(periods, np.broadcast_to(3 * periods[:, None] ** exponent, (7, 64)))
    assert found == pytest.approx(exponent, abs=1e-12) and error < 1e-12


def test_the_error_of_an_exponent_is_its_scatter():
    """The reported error is the scatter of the exponent over random walks; longer walks contain the shorter ones."""
    periods = np.array([10, 32, 100, 316, 1000])
    walks = np.random.default_rng(1).normal(size=(200, 1000, 32)).cumsum(axis=1)[:, periods - 1]
    found, error = growth(periods, walks)
    assert found.mean() == pytest.approx(0.5, abs=0.02)
    assert error.mean() == pytest.approx(found.std(), rel=0.2)


def test_values_without_growth_have_no_law():
    periods = np.array([1, 10, 100])
    for values in (np.zeros((3, 4)), np.full((3, 4), np.nan), np.ones((3, 1))):
        assert np.isnan(growth(periods, values)).all()
    assert np.isnan(growth(np.array([1, 1000]), np.ones((2, 4)))).all()


@pytest.fixture
def harmonic(monkeypatch, tmp_path) -> xr.Dataset:
    """Dataset that the experiment makes of runs on the harmonic oscillator."""
    phase = np.linspace(0, 1, 65)
    reference = xr.Dataset(
        {
            "u": ("t", np.cos(OMEGA * phase)),
            "v": ("t", -OMEGA * np.sin(OMEGA * phase)),
            "period": 1.0,
            "period_remainder": 0.0,
        },
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "hardening"},
    )
    monkeypatch.setattr(experiment.io, "open_dataset", lambda name: reference)
    monkeypatch.setattr(experiment, "problems_by_name", {"hardening": HARMONIC})
    return summary(long_runs("hardening", ["average_acceleration"], 20, [1, 4, 10], 4, list(ARITHMETIC)))


def test_errors_of_the_experiment_are_those_of_linear_theory(harmonic):
    dt = 1 / 20
    elongation = _period("average_acceleration", dt) - 1
    late = harmonic.phase_error.sel(scheme="average_acceleration", arithmetic="float64")
    np.testing.assert_allclose(late, np.broadcast_to(elongation * harmonic.periods, late.shape), rtol=1e-2)
    assert (harmonic.status == 0).all() and (harmonic.failed_at_step == -1).all()
    assert np.isnan(harmonic.energy_round_off.sel(arithmetic="float64_compensated")).all()
    single, double = (harmonic.energy_round_off.sel(arithmetic=name) for name in ("float32", "float64"))
    assert (single > 1e-9).all() and (double < 1e-14).all()
    assert harmonic.exponent.sel(quantity="phase_error").values == pytest.approx(1.0, abs=1e-2)


def test_failures_are_recorded():
    along = ("scheme", "arithmetic", "step", "periods", "run")
    ok = np.ones((1, 4, 2, 3, 2))
    names = "energy_error", "max_energy_error", "mean_energy_error", "phase_error"
    observed = {name: ok.copy() for name in names} | {
        "status": (0 * ok).astype(int),
        "failed_at_step": (-ok).astype(int),
    }
    observed["status"][0, 0, 1, 2] = 2, 1
    observed["failed_at_step"][0, 0, 1, 2] = 700, 300
    observed["energy_error"][0, 0, 1, 2] = np.nan
    runs = xr.Dataset(
        {name: (along, values) for name, values in observed.items()} | {"step_size": (along[2::2], ok[0, 0, :, 0])}
    )
    ds = summary(runs.assign_coords(periods=[1, 10, 100], arithmetic=list(ARITHMETIC), step=list(BITS)))
    cell = ds.isel(scheme=0, arithmetic=0, step=1, periods=2)
    assert cell.status == 1 and cell.failed_at_step == 300 and np.isnan(cell.energy_error)
    assert (ds.status != 0).sum() == 1 and np.isnan(ds.energy_error).sum() == 1


def test_long_jobs_are_split_by_arithmetic():
    schemes = ["average_acceleration", "gauss4"]
    options = {"schemes": schemes, "steps_per_period": 20, "runs": 16}
    short, long = ({**options, "periods": [10, 100, length]} for length in (1000, 10**6))
    for chosen, number in ((short, 2), (long, 8)):
        jobs = experiment._jobs(chosen).values()
        runs = [(scheme, a) for job in jobs for scheme in job["schemes"] for a in job["arithmetics"]]
        assert len(jobs) == number and sorted(runs) == sorted((scheme, a) for scheme in schemes for a in ARITHMETIC)
