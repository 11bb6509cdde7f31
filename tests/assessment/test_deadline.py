"""The limit on the wall time of a reference."""

import math
import time

import jax.numpy as jnp
import numpy as np
import pytest

import study
from reference import diffrax, sundials, taylor
from study.algebra.deadline import check_time, deadline
from study.assessment.deadline import Budget, OutOfTime, within

FAST = study.Problem(lambda u: 1e8 * u + u**3, 1.0, title="fast")


def test_an_error_of_a_solver_is_no_lack_of_time():
    with pytest.raises(ZeroDivisionError), within(math.inf, "late"):
        raise ZeroDivisionError
    assert deadline() == math.inf


@pytest.mark.slow
@pytest.mark.parametrize("route", [diffrax.trajectory, sundials.trajectory, taylor.trajectory])
def test_a_route_gives_up_when_the_time_is_over(route):
    """A motion of three million periods, which no route finishes in half a second."""
    start = time.monotonic()
    with pytest.raises(OutOfTime, match="too late"), within(start + 0.5, "too late"):
        route(FAST, np.linspace(0, 2000.0, 2001)[1:], 1e-10)
    assert 0.5 <= time.monotonic() - start < 40


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hardening", "yielding"])
def test_a_limit_on_the_time_changes_no_solution(name):
    """A solution in pieces that is restarted wrongly."""
    problem, t = study.problems[name], np.linspace(0, 1.0, 72)[1:]
    without = diffrax.trajectory(problem, t, 1e-10)
    with within(time.monotonic() + 600, ""):
        in_pieces = diffrax.trajectory(problem, t, 1e-10)
    assert in_pieces.u.shape == without.u.shape
    np.testing.assert_allclose(in_pieces.u, without.u, rtol=0, atol=1e-9 * np.abs(without.u).max())


def test_work_begins_only_if_there_is_time_for_the_longest_of_its_kind():
    budget = Budget(time.monotonic() + 5.0)
    assert budget.allows("map")
    budget.took("map", 10.0)
    budget.took("map", 1.0)
    assert not budget.allows("map") and budget.allows("other")
    late = Budget(0.0)
    with late.work("run"):
        check_time()
    assert not late.allows("run")
    check_time()


def test_a_load_that_may_have_kinks_is_named_where_the_time_ends():
    pulse = study.Problem(lambda u: u, 0.01, load=lambda t: jnp.where((t > 8) & (t < 8.02), 50.0, 0.0))
    with pytest.raises(OutOfTime, match=r"or a shorter duration, or give the load an attribute kinks .*: 1 unknown"):
        study.assess(pulse, "rk4", duration=20.0, seconds=0.0)
