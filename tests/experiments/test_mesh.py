"""Panels of masses, and the times that two schemes need on them."""

import numpy as np
import pytest

from study.experiments.mesh import SCHEMES, mesh, panel, seconds_of_step
from study.marching.run import run


@pytest.mark.slow
def test_the_frequencies_are_those_of_the_chain_in_closed_form():
    # masses 1 joined by springs n², fixed at one end: ωₖ = 2 n sin((2k − 1) π / (4n + 2))
    _, lowest, highest = panel(10, 1, 1.0)
    angles = np.pi / (4 * 10 + 2) * np.array([1, 19])
    assert [lowest, highest] == pytest.approx(20 * np.sin(angles))
    # the columns move alike in the lowest mode
    assert panel(10, 3, 1.0)[1] == pytest.approx(lowest)


@pytest.mark.slow
def test_the_row_is_stiffer_and_the_springs_yield():
    """A panel that stays elastic, or whose stiff row is not stiffer."""
    soft, _, highest = panel(4, 3, 1.0)
    assert panel(4, 3, 100.0)[2] > 5 * highest
    small = run(soft, "central_difference", dt=0.01, steps=400, observe=["trajectory"]).u
    large = run(soft, "central_difference", dt=0.01, steps=400, v0=4 * soft.v0, observe=["trajectory"]).u
    assert abs(large).max() > 4.5 * abs(small).max()


def test_the_explicit_scheme_follows_the_mesh_and_the_implicit_one_the_motion():
    """An explicit step that is not limited by the mesh, or an implicit one that is."""
    ds = mesh([[4, 1]], [1.0, 400.0], [20, 40, 80], 2.0, 0.02, 1)
    steps = dict(zip(SCHEMES, ds.steps_per_period.values.T, strict=True))
    assert steps["central_difference"] == pytest.approx(np.ceil(1.02 * np.pi * ds.mesh_ratio.values), abs=1)
    assert steps["average_acceleration"][1] <= 40 and ds.mesh_ratio[1] > 10 * ds.mesh_ratio[0]
    assert (ds.reference_difference < 0.005).all() and (ds.peak_error <= 0.02).all()
    # the steps that keep the error are among those tried, and the finest explicit run is the reference
    kept = (ds.tried_peak_error == ds.peak_error) & (abs(ds.tried_seconds / ds.seconds_per_period - 1) < 1e-9)
    assert kept.any("tried").all() and (ds.tried_peak_error.isel(tried=2).sel(scheme="central_difference") == 0).all()
    assert (ds.tried_seconds > 0).all()


def test_one_slow_run_does_not_end_the_lengthening_of_short_runs():
    """A run of few steps that other work slowed once: its time less that of a call may be negative."""

    class Timer:
        def shortest(self, dt, steps, enough):
            return min(self.run(dt, steps)[0] for _ in range(3))

        def run(self, dt, steps):
            self.runs, self.longest = getattr(self, "runs", 0) + 1, 1e-5 + 1e-7 * steps
            return (1.0 if self.runs == 1 else self.longest), True

    timer = Timer()
    assert seconds_of_step(timer, 0.1, 40, call=1e-5) == pytest.approx(1e-7)
    assert timer.longest > 100 * 1e-5
