"""Errors and times of solvers with step size control."""

import numpy as np
import pytest

from reference.experiments import work_precision
from reference.solution import Solution


def test_a_solver_that_gives_up_or_takes_too_long_is_left_out(monkeypatch):
    def slow(problem, t, tolerance):
        return Solution(np.zeros_like(t), np.zeros_like(t), 100, 1.0)

    monkeypatch.setattr(work_precision, "SOLVERS", {"heyoka": work_precision.SOLVERS["heyoka"], "kvaerno5": slow})
    ds = work_precision.work_precision(["hardening"], [1e-6, 1e-8], [1, 100, 1000], repeats=2, longest=0.5)
    # a solution of zeros errs by the amplitude, which is reached at the end of a period
    error = ds.solver_last_period_error.squeeze("problem")
    assert error.sel(solver="kvaerno5").values[0, :2] == pytest.approx(1.0)
    assert (error.sel(solver="heyoka", periods=1) < 1e-5).all()
    time = ds.median_solver_seconds.squeeze("problem")
    assert np.isfinite(time.sel(solver="heyoka")).all()
    slow_one = time.sel(solver="kvaerno5")
    np.testing.assert_allclose(slow_one.isel(tolerance=0), [0.01, 1.0, np.nan])
    assert np.isnan(slow_one.isel(tolerance=1)).all()
