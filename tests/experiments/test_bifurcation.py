"""Bifurcation diagrams over the step size."""

import numpy as np
import pytest

import study
from study.experiments.bifurcation import bifurcation
from study.marching.result import UNBOUNDED


@pytest.mark.slow
def test_a_bifurcation_diagram_separates_order_from_chaos():
    ds = bifurcation("double_well", "average_acceleration", {"first": 1.0, "last": 2.6, "count": 5}, 600, 50, 1e-10)
    regular, chaotic = ds.isel(step_size=0), ds.isel(step_size=-1)
    assert regular.lyapunov_exponent < 0.05 < chaotic.lyapunov_exponent
    assert regular.steps_until_apart == -1 and 0 < chaotic.steps_until_apart < 600
    assert (regular.u > 0).all() and chaotic.u.min() < 0 < chaotic.u.max()


def test_a_bifurcation_diagram_shows_what_was_before_a_failure():
    ds = bifurcation("double_well", "central_difference", {"first": 2.5, "last": 2.7, "count": 5}, 2000, 50, 1e-10)
    assert (ds.status == UNBOUNDED).all()
    np.testing.assert_array_equal(ds.u.notnull().sum("iterate"), np.minimum(ds.failed_at_step, 50))
    assert (ds.u.max("iterate") > 0).all() and (ds.lyapunov_exponent > 0).all()
    alone = study.run("double_well", "central_difference", dt=2.5, steps=int(ds.failed_at_step[0]) - 1)
    np.testing.assert_allclose(ds.u.isel(step_size=0, iterate=-1), alone.u[-1], rtol=1e-3)
