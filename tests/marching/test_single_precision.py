"""Runs in single precision."""

import jax
import numpy as np
import pytest

import study


@pytest.mark.slow
def test_schemes_run_in_single_precision(sampled_kind):
    """A number in double precision in a scheme, which makes its whole run one of double precision."""
    arguments = {"dt": 2.0**-8, "steps": 64, "observe": ["trajectory", "max_energy_error"]}
    double = study.run("hardening", sampled_kind, **arguments)
    with jax.enable_x64(False):
        single = study.run("hardening", sampled_kind, **arguments)
    assert single.u.dtype == np.float32 and single.status == 0
    difference = np.abs(single.u - double.u).max().item()
    # the difference is above zero and at most a few hundred round-offs; Houbolt's method divides by Δt², and loses more
    assert 1e-8 < difference < (2e-3 if sampled_kind == "houbolt" else 5e-5)


def test_an_ensemble_keeps_its_precision_on_every_core(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with jax.enable_x64(False):
        ds = study.run("hardening", "rk4", dt=0.005, u0=np.linspace(1, 2, 300), steps=10)
    assert ds.u.dtype == np.float32 and (ds.status == 0).all()


def test_problems_are_made_and_checked_in_double_precision():
    with jax.enable_x64(False):
        problem = study.Problem(potential=lambda u: u**2 / 2 + u**4 / 4, u0=1.0)
        ds = study.run(problem, "average_acceleration", dt=0.1, steps=100, observe=["max_energy_error"])
    assert ds.status == 0 and 0 < ds.max_energy_error < 0.01


def test_steps_that_single_precision_cannot_count_are_refused():
    with jax.enable_x64(False), pytest.raises(ValueError, match="steps must be a whole number of at least 1 and at mo"):
        study.run("hardening", "rk4", dt=0.01, steps=2**31, observe=["max_energy_error"])


def test_a_structure_in_single_precision():
    """The tolerances of Newton's iteration for several unknowns depend on the precision, so that the run succeeds."""
    with jax.enable_x64(False):
        ds = study.run("fpu_chain", "energy_momentum", dt=0.01, steps=100, observe=["max_energy_error"])
    assert ds.status == 0 and ds.max_energy_error < 1e-4


def _single_round_off(scheme, dt, steps):
    """Round-off of the mean energy error: its root mean square deviation from runs in compensated double precision."""
    observed = []
    for double, method in ((False, scheme), (True, study.Compensated(scheme=scheme))):
        with jax.enable_x64(double):
            ds = study.run("hardening", method, dt=dt, steps=steps, observe=["mean_energy_error"])
        observed.append(ds.mean_energy_error.values.astype(float))
    return np.sqrt(np.mean((observed[0] - observed[1]) ** 2))


@pytest.mark.slow
def test_single_precision_drifts_where_it_rounds_the_square_of_the_step():
    """If Δt² is rounded, the energy drifts in Newmark's form of central difference, but not in kicks and drifts."""
    short = np.ldexp(np.arange(3936, 4064), -19)
    long = short + np.ldexp(1365, -31)
    newmark, verlet = study.schemes["central_difference"], study.Composition(weights=(1.0,), order_without_damping=2)
    steady = _single_round_off(newmark, short, 60_000)
    assert _single_round_off(newmark, long, 60_000) > 3 * steady
    assert _single_round_off(verlet, long, 60_000) < 2 * steady


def test_single_precision_comes_back_bit_for_bit():
    """Without an energy drift the run becomes periodic, because few single-precision numbers lie near the orbit."""
    with jax.enable_x64(False):
        ds = study.run("hardening", "yoshida4", dt=np.ldexp(3972, -19), steps=200_000)
    states = list(zip(ds.u.values.tolist(), ds.v.values.tolist(), strict=True))
    first = {state: step for step, state in reversed(list(enumerate(states)))}
    closed = next(step for step, state in enumerate(states) if first[state] < step)
    cycle = closed - first[states[closed]]
    assert cycle > 20 and states[closed:] == states[closed - cycle : -cycle]
