"""Errors and times of solvers with step size control."""

import numpy as np
import pytest

import study
from reference import exact
from reference.experiments import work_precision
from reference.solution import Solution


def test_errors_of_a_late_and_of_a_damped_solution():
    """Errors of a solution that is late by 1e-6 of a period, and of one whose amplitude is too small by 1e-6."""
    problem = study.problems["hardening"]
    exact_period, certified = exact.period(problem, 0.15)
    period = float(exact_period)
    t = period * (99 + np.arange(1, 17) / 16)
    truth = exact.folded(problem, t, exact_period, certified)
    late = exact.folded(problem, t - 1e-6 * period, exact_period, certified)
    errors = work_precision.errors(problem, truth, Solution(late.u, late.v, 0, 0.0), 100, period)
    assert errors["phase_error"] == pytest.approx(1e-6, rel=1e-3)
    assert errors["period_elongation"] == pytest.approx(1e-8, rel=1e-3)
    assert errors["max_energy_error"] < 1e-14
    smaller = Solution(truth.u * (1 - 1e-6), truth.v, 0, 0.0)
    assert work_precision.errors(problem, truth, smaller, 100, period)["amplitude_decay"] == pytest.approx(
        1e-8, rel=1e-3
    )
    assert errors["max_trajectory_error"] == pytest.approx(np.max(np.abs(late.u - truth.u)) / 1.5)


def test_a_solver_that_gives_up_or_takes_too_long_is_left_out(monkeypatch):
    def slow(problem, t, tolerance):
        return Solution(np.zeros_like(t), np.zeros_like(t), 100, 1.0)

    monkeypatch.setattr(work_precision, "SOLVERS", {"heyoka": work_precision.SOLVERS["heyoka"], "kvaerno5": slow})
    ds = work_precision.work_precision(["hardening"], [1e-6, 1e-8], [8], [1, 100, 1000], repeats=2, longest=0.5)
    time = ds.median_solver_seconds.squeeze("problem")
    assert np.isfinite(time.sel(solver="heyoka")).all()
    slow_one = time.sel(solver="kvaerno5")
    np.testing.assert_allclose(slow_one.isel(tolerance=0), [0.01, 1.0, np.nan])
    assert np.isnan(slow_one.isel(tolerance=1)).all()
