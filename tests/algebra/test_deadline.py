"""A deadline for long computations."""

import math
import time

import numpy as np
import pytest

import study
from study.algebra.deadline import deadline, until


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [0, 2])
@pytest.mark.parametrize("steps", [{"dt": 1e-3, "steps": 10**9}, {"tolerance": 1e-4, "duration": 1e6, "steps": 10**9}])
def test_a_run_is_given_up_soon_after_the_deadline(steps, lanes):
    """Runs that would take days; lanes run in other threads."""
    problem = study.Problem(lambda u: u, np.ones(2000))
    starts = {"u0": np.ones((lanes, 2000))} if lanes else {}
    with pytest.raises(TimeoutError), until(time.monotonic() + 0.1):
        study.run(problem, "rk4", observe=[], **steps, **starts)
    assert deadline() == math.inf
