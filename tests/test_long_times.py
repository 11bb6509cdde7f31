"""Oscillations counted, single precision, compensated sums over long runs, and laws of growth."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import xarray as xr

import study
from study.experiments import long_times as experiment
from study.experiments.long_times import growth, long_times, summary
from study.observer.crossings import Oscillations, _crossing

OMEGA = 2 * np.pi
HARMONIC = study.Problem(lambda u: OMEGA**2 * u, potential=lambda u: OMEGA**2 * u * u / 2, u0=1.0, title="harmonic")


def _period(scheme, dt):
    """Of the scheme on the harmonic oscillator, by linear theory."""
    half = OMEGA * dt / 2
    return np.pi * dt / {"average_acceleration": np.arctan, "central_difference": np.arcsin}[scheme](half)


@pytest.mark.parametrize("scheme", ["average_acceleration", "central_difference"])
@pytest.mark.parametrize("double, accuracy", [(True, 3e-11), (False, 1e-7)])
def test_the_period_is_that_of_linear_theory(scheme, double, accuracy):
    dt = 2.0**-6
    with jax.enable_x64(double):
        ds = study.run(HARMONIC, scheme, dt=dt, steps=2_000_000, observe=["oscillations"])
    period = _period(scheme, dt)
    # from rest the first crossing comes at three quarters
    assert ds.crossings == np.floor(2_000_000 * dt / period + 0.25)
    assert ds.mean_period.item() == pytest.approx(period, rel=accuracy)
    last = (ds.crossings.item() - 0.25) * period / dt
    # what single precision loses of the phase of 31,250 periods, and what interpolation leaves
    assert ds.last_crossing_step.item() + ds.last_crossing_part.item() == pytest.approx(last, abs=1e-4 if double else 2)
    assert ds.last_crossing_step % 1 == 0 and 0 < ds.last_crossing_part <= 1


def test_steps_beyond_the_digits_of_single_precision_are_counted():
    steps = 2**24 + 5
    # at the limit of stability, ωΔt = 2, central difference goes from −½ to ½ and back, without round-off
    problem = study.Problem(lambda u: 4.0 * u, u0=-0.5, v0=0.0)
    with jax.enable_x64(False):
        ds = study.run(problem, "central_difference", dt=1.0, steps=steps, observe=["oscillations"])
    assert ds.crossings == steps // 2 + 1
    assert ds.last_crossing_step == steps - 1 and ds.last_crossing_part == 0.5


def test_lanes_and_unknowns_oscillate_on_their_own():
    problem = study.Problem(lambda u: jnp.asarray([1.0, 4.0]) * OMEGA**2 * u, u0=[1.0, 1.0], tangent="diagonal")
    arguments = {"steps": 4000, "observe": ["oscillations"]}
    dt = np.array([0.001, 0.002])
    lanes = study.run(problem, "average_acceleration", dt=dt, **arguments)
    assert lanes.crossings.dims == ("lane", "component")
    np.testing.assert_array_equal(lanes.crossings, [[4, 8], [8, 16]])
    np.testing.assert_allclose(lanes.mean_period, [[1.0, 0.5]] * 2, rtol=1e-4)
    np.testing.assert_allclose(
        study.run(problem, "average_acceleration", dt=0.002, **arguments).mean_period, lanes.mean_period[1], rtol=1e-12
    )


def test_a_level_that_is_crossed_once_has_no_mean_period():
    ds = study.run(HARMONIC, "rk4", dt=0.01, steps=100, observe=[Oscillations()])
    assert ds.crossings == 1 and np.isnan(ds.mean_period)
    assert ds.last_crossing_step + ds.last_crossing_part == pytest.approx(75, abs=1e-4)
    above = study.run(HARMONIC, "rk4", dt=0.01, steps=300, observe=[Oscillations(level=2.0)])
    assert above.crossings == 0 and np.isnan(above.mean_period)
    high = study.run(HARMONIC, "rk4", dt=0.01, steps=300, observe=[Oscillations(level=0.5)])
    assert high.last_crossing_step + high.last_crossing_part == pytest.approx(200 + 500 / 6, abs=1e-4)


def test_a_crossing_never_leaves_its_step():
    """Where velocities say nothing of the way between two steps: at rest, running back, or far too fast."""
    for start in (0.0, -5.0, 1e9, 1e-300):
        for end in (0.0, -5.0, 1e9, 1e-300):
            part = _crossing((jnp.asarray(-0.2), jnp.asarray(start)), (jnp.asarray(0.3), jnp.asarray(end)), 0.1, 0.0)
            assert 0 <= part <= 1


def test_the_mean_of_the_energy_error_is_that_of_the_samples(kind):
    ds = study.run("hardening", kind, dt=0.0075, steps=200, observe=["energy_error", "mean_energy_error"])
    assert ds.mean_energy_error.item() == pytest.approx(ds.energy_error[1:].mean().item(), rel=1e-9, abs=1e-12)


def test_schemes_run_in_single_precision(kind):
    arguments = {"dt": 2.0**-8, "steps": 64, "observe": ["trajectory", "max_energy_error"]}
    double = study.run("hardening", kind, **arguments)
    with jax.enable_x64(False):
        single = study.run("hardening", kind, **arguments)
    assert single.u.dtype == np.float32 and single.status == 0
    difference = np.abs(single.u - double.u).max().item()
    # by more than nothing, and by no more than some hundred round-offs; differences over Δt² lose more
    assert 1e-8 < difference < (2e-3 if kind == "houbolt" else 5e-5)


def test_an_ensemble_keeps_its_precision_on_every_core(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with jax.enable_x64(False):
        ds = study.run("hardening", "rk4", dt=0.005, u0=np.linspace(1, 2, 300), steps=10)
    assert ds.u.dtype == np.float32 and (ds.status == 0).all()


def test_problems_are_made_and_checked_in_double_precision():
    with jax.enable_x64(False):
        problem = study.Problem(potential=lambda u: u**2 / 2 + u**4 / 4, u0=1.0)
        ds = study.run(problem, "average_acceleration", dt=0.1, steps=100, observe=["max_energy_error"])
    assert ds.status == 0 and 0 < ds.max_energy_error < 1


def test_steps_that_single_precision_cannot_count_are_refused():
    with jax.enable_x64(False), pytest.raises(ValueError, match="steps must be a whole number of at least 1 and at mo"):
        study.run("hardening", "rk4", dt=0.01, steps=2**31, observe=["max_energy_error"])


def test_a_structure_in_single_precision():
    """Tolerances of several unknowns follow the precision too."""
    with jax.enable_x64(False):
        ds = study.run("fpu_chain", "energy_momentum", dt=0.01, steps=100, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 1e-2


def test_compensated_sums_lower_the_round_off():
    """Of the energy of the orbit, with a step whose square single precision holds."""
    dt = np.ldexp(np.arange(4000, 4064), -20)
    errors = {}
    for name, double, scheme in (
        ("exact", True, study.Compensated(study.schemes["central_difference"])),
        ("plain", False, study.schemes["central_difference"]),
        ("compensated", False, study.Compensated(study.schemes["central_difference"])),
    ):
        with jax.enable_x64(double):
            ds = study.run("hardening", scheme, dt=dt, steps=10_000, observe=["mean_energy_error"])
        errors[name] = ds.mean_energy_error.values.astype(float)
    plain, compensated = (np.std(errors[name] - errors["exact"]) for name in ("plain", "compensated"))
    assert 0 < compensated < plain / 2


def _single_round_off(scheme, dt, steps):
    """Of the mean energy error of every run, against compensated double precision."""
    observed = []
    for double, method in ((False, scheme), (True, study.Compensated(scheme))):
        with jax.enable_x64(double):
            ds = study.run("hardening", method, dt=dt, steps=steps, observe=["mean_energy_error"])
        observed.append(ds.mean_energy_error.values.astype(float))
    return np.sqrt(np.mean((observed[0] - observed[1]) ** 2))


def test_single_precision_drifts_where_it_rounds_the_square_of_the_step():
    """Newmark's form of central difference; the same scheme as kicks and drifts, velocity Verlet, does not."""
    short = np.ldexp(np.arange(3936, 4064), -19)
    long = short + np.ldexp(1365, -31)
    newmark, verlet = study.schemes["central_difference"], study.Composition((1.0,), of_order=2)
    steady = _single_round_off(newmark, short, 60_000)
    assert _single_round_off(newmark, long, 60_000) > 3 * steady
    assert _single_round_off(verlet, long, 60_000) < 2 * steady


def test_single_precision_comes_back_bit_for_bit():
    """Without a drift: the numbers near the orbit are finite in number."""
    with jax.enable_x64(False):
        ds = study.run("hardening", "yoshida4", dt=np.ldexp(3972, -19), steps=200_000)
    states = list(zip(ds.u.values.tolist(), ds.v.values.tolist(), strict=True))
    first = {state: step for step, state in reversed(list(enumerate(states)))}
    closed = next(step for step, state in enumerate(states) if first[state] < step)
    cycle = closed - first[states[closed]]
    assert cycle > 20 and states[closed:] == states[closed - cycle : -cycle]


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5])
def test_a_law_of_growth_is_recovered_with_its_error(exponent):
    periods = np.array([1, 3, 10, 32, 100, 316, 1000])
    values = np.random.default_rng(0).normal(size=(2, 7, 64)) * periods[:, None] ** exponent
    found, error = growth(periods, values)
    assert np.all(np.abs(found - exponent) < 4 * error) and np.all((0.01 < error) & (error < 0.1))
    # the same from run to run is known without scatter
    found, error = growth(periods, np.broadcast_to(3 * periods[:, None] ** exponent, (7, 64)))
    assert found == pytest.approx(exponent, abs=1e-12) and error < 1e-12


def test_the_error_of_an_exponent_is_its_scatter():
    """Of random walks, whose lengths share their past."""
    periods = np.array([10, 32, 100, 316, 1000])
    walks = np.random.default_rng(1).normal(size=(200, 1000, 32)).cumsum(axis=1)[:, periods - 1]
    found, error = growth(periods, walks)
    assert found.mean() == pytest.approx(0.5, abs=0.02)
    assert error.mean() == pytest.approx(found.std(), rel=0.2)


def test_no_law_is_made_of_nothing():
    periods = np.array([1, 10, 100])
    for values in (np.zeros((3, 4)), np.full((3, 4), np.nan), np.ones((3, 1))):
        assert np.isnan(growth(periods, values)).all()
    assert np.isnan(growth(np.array([1, 1000]), np.ones((2, 4)))).all()


@pytest.fixture
def harmonic(monkeypatch, tmp_path) -> xr.Dataset:
    """The experiment on the harmonic oscillator."""
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
    monkeypatch.setattr(experiment.datasets, "open", lambda name: reference)
    monkeypatch.setattr(experiment, "problems_by_name", {"hardening": HARMONIC})
    return long_times("hardening", ["average_acceleration"], 20, [1, 4, 10], runs=4)


def test_errors_of_the_experiment_are_those_of_linear_theory(harmonic):
    dt = 1 / 20
    elongation = _period("average_acceleration", dt) - 1
    late = harmonic.phase_error.sel(scheme="average_acceleration", arithmetic="float64")
    np.testing.assert_allclose(late, np.broadcast_to(elongation * harmonic.periods, late.shape), rtol=1e-2)
    assert (harmonic.status == 0).all() and (harmonic.failed_at_step == -1).all()
    assert np.isnan(harmonic.energy_round_off.sel(arithmetic="float64_compensated")).all()
    single, double = (harmonic.energy_round_off.sel(arithmetic=name) for name in ("float32", "float64"))
    assert (single > 1e-7).all() and (double < 1e-12).all()
    assert harmonic.exponent.sel(quantity="phase_error").values == pytest.approx(1.0, abs=1e-2)


def test_failures_are_recorded():
    ok = np.ones((1, 4, 2, 3, 2))
    observed = {name: ok.copy() for name in ("energy_error", "max_energy_error", "mean_energy_error", "phase_error")}
    observed |= {"status": 0 * ok, "failed_at_step": -ok}
    observed["status"][0, 0, 1, 2] = 2, 1
    observed["failed_at_step"][0, 0, 1, 2] = 700, 300
    observed["energy_error"][0, 0, 1, 2] = np.nan
    ds = summary(observed, np.array([1, 10, 100]))
    cell = ds.isel(scheme=0, arithmetic=0, step=1, periods=2)
    assert cell.status == 1 and cell.failed_at_step == 300 and np.isnan(cell.energy_error)
    assert (ds.status != 0).sum() == 1 and np.isnan(ds.energy_error).sum() == 1
