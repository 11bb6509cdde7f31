"""Experiments on the springs of Xie (1996), each on its smallest case with a known answer."""

import math

import numpy as np
import pytest
import xarray as xr

import study
from paper import terms
from paper.published import printed_cpu_times, printed_energy_errors, same, twice
from study import io
from study.experiments.cpu_time import cpu_time
from study.experiments.energy_drift import energy_drift
from study.experiments.energy_error import energy_error
from study.experiments.houbolt_start import houbolt_start
from study.experiments.large_steps import large_steps
from study.experiments.phase_portrait import phase_portrait
from study.experiments.relaxation import relaxation
from study.experiments.sensitivity import APART, sensitivity
from study.experiments.spectral import spectral
from study.experiments.step_window import step_window
from study.marching.result import UNBOUNDED

PRINTED = printed_energy_errors()


def test_energy_errors_are_the_printed_ones(monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: xr.Dataset({"period": 0.1509}))
    steps = [15, 20]
    ours = energy_error(["hardening"], ["rk4", "central_difference"], steps, periods=100)
    printed = PRINTED.sel(problem="hardening", steps_per_period=steps, scheme=ours.scheme)
    errors = ours.max_energy_error.sel(problem="hardening")
    np.testing.assert_allclose(errors.sel(period_used="printed"), printed / 100, atol=6e-4)
    # the exact period gives another step size
    assert (abs(errors.sel(period_used="exact") - errors.sel(period_used="printed")) > 1e-5).all()
    assert (ours.status == 0).all() and (ours.failed_at_step == -1).all()


def test_only_houbolts_own_start_gives_the_printed_error():
    error = 100 * houbolt_start(["hardening"], [20], periods=100).max_energy_error.squeeze()
    printed = PRINTED.sel(problem="hardening", scheme="houbolt", steps_per_period=20).item()
    # ``twice`` rounds to two decimals and then to one, as the numbers of 1996 were rounded
    met = error.start[same(twice(error), printed)]
    assert met.values.tolist() == ["linear_acceleration"] and error.sizes["start"] == 4


def test_relaxation_keeps_the_energy_of_the_runs_of_the_tables(monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: xr.Dataset({"period": 0.151532834447260357}))
    ds = relaxation(["hardening"], [20, 200], periods=100).squeeze()
    printed = PRINTED.sel(problem="hardening", scheme="rk4", steps_per_period=20).item()
    assert ds.max_energy_error.sel(variant="plain", steps_per_period=20) == pytest.approx(printed / 100, abs=6e-4)
    assert (ds.max_energy_error.sel(variant="relaxed") < 1e-11).all()
    # relaxation reduces the error of the motion, which still falls with the fourth order of the method
    assert (ds.return_error.sel(variant="relaxed") < ds.return_error.sel(variant="plain")).all()
    coarse, fine = ds.return_error.sel(variant="relaxed")
    assert np.log10(coarse / fine) == pytest.approx(4, abs=0.3)


def test_a_step_that_is_too_large_fails_or_loses_the_energy():
    runs = large_steps(["double_well"], ["central_difference"], [0.01, 0.4], periods=20).squeeze()
    assert runs.status.values.tolist() == [0, UNBOUNDED] and runs.failed_at_step[0] == -1
    assert runs.max_energy_error[0] < 0.01 and np.isnan(runs.max_energy_error[1])
    assert abs(runs.energy_drift[0]) <= runs.max_energy_error[0]


def _late_gain_of_wilson(dt: float, steps: int) -> float:
    """Largest gain of energy in the second half of u'' + 100 tanh u = 0 from rest at 10; bisection solves each step."""

    def energy(u, v):
        return v * v / 2 + 100 * (abs(u) + math.log1p(math.exp(-2 * abs(u))) - math.log(2))

    u, v, a, tau, energies = 10.0, 0.0, -100 * math.tanh(10.0), 1.4 * dt, []
    for _ in range(steps):
        known = u + tau * v + tau**2 * a / 3
        low, high = known - 100 * tau**2 / 6, known + 100 * tau**2 / 6
        for _ in range(60):
            middle = (low + high) / 2
            above = middle + tau**2 / 6 * 100 * math.tanh(middle) > known
            low, high = (low, middle) if above else (middle, high)
        new = a + (-100 * math.tanh(middle) - a) / 1.4
        u, v, a = u + dt * v + dt**2 * (a / 3 + new / 6), v + dt * (a + new) / 2, new
        energies.append(energy(u, v))
    return max(energies[steps // 2 :]) / energy(10.0, 0.0) - 1


def test_wilsons_method_gains_energy_late_at_some_step():
    late = large_steps(["softening_large"], ["wilson_theta"], [0.14, 0.164], periods=100).late_energy_gain.squeeze()
    # the motion is chaotic, so that only the class of the outcome is the same
    gains = [_late_gain_of_wilson(1.8 * part, round(100 / part)) for part in (0.14, 0.164)]
    assert gains[0] < 0 < 1 < gains[1] and late[0] < 0 < 1 < late[1]


def test_times_are_ratios_to_average_acceleration():
    timed = cpu_time(["hardening"], ["average_acceleration", "rk4"], steps_per_period=1000, steps=2000, repeats=3)
    assert set(timed.scheme.values) <= set(printed_cpu_times().scheme.values)
    assert (timed.seconds_per_step > 0).all() and timed.sizes["repeat"] == 3 and (timed.seconds_to_compile > 0).all()
    assert timed.ratio.sel(scheme="average_acceleration") == 1
    median = timed.seconds_per_step.median("repeat")
    np.testing.assert_allclose(timed.median_seconds_per_step, median)
    ratios = timed.seconds_per_step / timed.seconds_per_step.sel(scheme="average_acceleration", drop=True)
    quartiles = ratios.quantile([0.25, 0.5, 0.75], "repeat").transpose("quantile", "problem", "scheme")
    np.testing.assert_allclose([timed.ratio_low, timed.ratio, timed.ratio_high], quartiles)


def test_a_resonance_holds_runge_kutta_at_a_whole_number_of_steps():
    parts = {"first": 20, "last": 25, "step": 5}
    drift = energy_drift("softening", "rk4", parts, periods=100, oscillations=20)
    printed = PRINTED.sel(problem="softening", scheme="rk4", steps_per_period=[20, 25])
    # with 20 steps a resonance holds the orbit, so the final drift is less than the printed largest error; with 25
    # steps the drift equals the largest error
    held, free = -100 * drift.energy_drift.values
    assert 0 < held < printed[0] and free == pytest.approx(printed[1].item(), abs=0.06)
    count = drift.steps_per_oscillation.values
    assert abs(count[0] - 20) < 0.01 and abs(count[1] - round(count[1])) > 0.1


def test_a_portrait_is_the_run_itself():
    portrait = phase_portrait("hardening", ["rk4", "houbolt"], dt=0.0075, duration=0.3)
    run = study.run("hardening", "houbolt", dt=0.0075, steps=40)
    np.testing.assert_array_equal(portrait.u.sel(scheme="houbolt"), run.u)
    assert portrait.step_size == 0.0075 and portrait.attrs["problem"] == "hardening"


def test_neighbours_part_only_where_the_motion_is_chaotic():
    perturbation = 1e-10
    parted = sensitivity("double_well", ["average_acceleration", "newmark_dissipative"], 2.5, 1000.0, perturbation)
    last = parted.separation.isel(t=slice(-50, None)).max("t")
    assert parted.separation.isel(t=0).values == pytest.approx(perturbation, rel=1e-3)
    assert last.sel(scheme="average_acceleration") > 0.1
    assert last.sel(scheme="newmark_dissipative") < 1e-3
    assert APART == terms.APART  # the texts of the claims state this distance
    chaotic, damped = (parted.sel(scheme=name) for name in ("average_acceleration", "newmark_dissipative"))
    assert (chaotic.parted_at_step[1:] > 40).all() and len(set(chaotic.changes_of_sign.values)) > 3
    assert (damped.parted_at_step == -1).all() and len(set(damped.changes_of_sign.values)) == 1


def test_a_window_of_steps_has_the_gains_of_single_runs():
    span = {"first": 0.12, "last": 0.13, "count": 3}
    window = step_window("softening_large", ["hht_alpha_1996"], span, perturbation=1e-3, periods=10).squeeze("scheme")
    assert window.largest_gain.shape == (3, 41) and (window.status == 0).all()
    for start, part in ((0, 0.125), (-20, 0.13)):
        single = study.run(
            "softening_large",
            "hht_alpha_1996",
            dt=1.8 * part,
            steps=round(10 / part),
            u0=10.0 + 1e-3 * start,
            observe="energy_error",
        )
        ours = window.largest_gain.sel(start=start).sel(step_size_over_period=part, method="nearest")
        assert ours == pytest.approx(single.energy_error.max().item(), rel=1e-6)


def test_linear_theory_of_two_schemes_that_are_known():
    theory = spectral(
        ["generalized_alpha", "central_difference"], {"first": -3, "last": 1, "per_decade": 40}, [0.0, 0.1]
    )
    free = theory.sel(damping_ratio=0.0)
    assert free.stability_limit.values == pytest.approx([np.inf, 2], rel=1e-3)
    assert free.infinite_frequency_radius.sel(scheme="generalized_alpha") == pytest.approx(0.8, abs=1e-5)
    np.testing.assert_allclose(theory.linear_order, 2, atol=0.05)
    # the acceleration of an α-method belongs to a time within the step
    assert free.order_rederived.sel(scheme="generalized_alpha") == pytest.approx(1, abs=0.1)
    assert theory.memory.values.tolist() == [3, 3]
