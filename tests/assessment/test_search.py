"""The search for the largest step that keeps an error, on errors that are made up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.assessment import ladder
from study.assessment.ladder import COARSEST_KEEPS, FINEST_FAILS, FOUND, UNCERTAIN, Ladder, Try


class MadeUp(Ladder):
    """A ladder whose runs have the error that a function of steps and start gives."""

    def __init__(self, error):
        self._error, self.tries, self.rungs, self._records, self.finest = error, {}, [], False, 4096
        self._cases = dict.fromkeys((1.0, *ladder.STARTS))  # type: ignore[assignment]

    def run(self, steps, start=1.0):
        if (steps, start) not in self.tries:
            self.tries[steps, start] = Try({"u": self._error(steps, start)}, 0, -1, 0.0, 0.0)
        return self.tries[steps, start]


def searched(error, allowed=0.01, uncertainty=0.0):
    made_up = MadeUp(error)
    made_up.climb(16, allowed)
    return made_up, made_up.verdicts([("u", allowed)], {"u": uncertainty})["u", allowed]


@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_step_of_a_regular_error_is_found(order):
    _, verdict = searched(lambda steps, start: start * (10 / steps) ** order, 0.01)
    exact = 10 / 0.01 ** (1 / order)
    assert verdict.how == FOUND and verdict.accidents == 0
    assert exact <= verdict.steps <= 1.1 * exact


def test_a_lucky_step_is_passed_over():
    """An error that falls to nothing at a rung only, as by locking, and one that does so for one start only."""

    def locked(steps, start):
        return 1e-6 if steps == 64 else (40 / steps) ** 2

    made_up, verdict = searched(locked)
    assert verdict.how == FOUND and verdict.steps >= 400
    assert made_up.run(64).errors["u"] < 0.01

    def at_this_start(steps, start):
        return 1e-6 if start == 1.0 and 64 <= steps <= 80 else (40 / steps) ** 2

    _, verdict = searched(at_this_start)
    assert verdict.steps >= 400


def test_the_ends_of_a_ladder_are_said_as_such():
    assert searched(lambda steps, start: 1e-5 / steps)[1] == (16, COARSEST_KEEPS, 0)
    assert searched(lambda steps, start: 0.5)[1][:2] == (-1, FINEST_FAILS)
    assert searched(lambda steps, start: np.nan)[1][:2] == (-1, FINEST_FAILS)
    assert searched(lambda steps, start: 1e-5, uncertainty=0.002)[1] == (-1, UNCERTAIN, 0)
    assert searched(lambda steps, start: 1e-5 if start == 1.0 else 1.0)[1][:2] == (-1, FINEST_FAILS)


@settings(max_examples=200, deadline=None)
@given(
    order=st.floats(0.5, 8),
    bumps=st.lists(st.tuples(st.floats(4.0, 12.0), st.floats(0.001, 1000)), max_size=8),
    allowed=st.floats(1e-4, 0.3),
)
def test_every_finer_run_keeps_the_error(order, bumps, allowed):
    """Whatever the error does between the steps: what was run decides."""

    def error(steps, start):
        factor = np.prod([size for place, size in bumps if abs(np.log2(steps) - place) < 0.1], initial=1.0)
        return factor * start * (20 / steps) ** order

    made_up, verdict = searched(error, allowed)
    if verdict.steps > 0:
        finer = [steps for steps in made_up.steps_of() if steps >= verdict.steps]
        assert len(finer) > 3 and all(error(steps, 1.0) <= allowed for steps in finer)
        assert all(made_up.tries[verdict.steps, start].errors["u"] <= allowed for start in ladder.STARTS)


@settings(max_examples=200, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    order=st.floats(0.5, 4),
    allowed=st.lists(st.floats(1e-3, 0.3), min_size=2, max_size=4, unique=True),
)
def test_no_verdict_is_contradicted_by_the_runs_of_another(seed, order, allowed):
    """Errors that jump from step to step, as where the motion is chaotic at coarse steps."""

    def error(steps, start):
        jump = np.random.default_rng((seed, steps)).lognormal(sigma=1.0)
        return jump * start * (20 / steps) ** order

    made_up = MadeUp(error)
    made_up.climb(16, min(allowed))
    found = made_up.verdicts([("u", limit) for limit in allowed], {"u": 0.0})
    for (_, limit), verdict in found.items():
        finer = [steps for steps in made_up.steps_of() if steps >= verdict.steps > 0]
        assert all(error(steps, 1.0) <= limit for steps in finer)


def test_a_start_that_needs_more_steps_sets_the_step():
    """The error of a smooth scheme from another start is larger by a fifth, as near a separatrix."""
    _, verdict = searched(lambda steps, start: (1.2 if start < 1 else 1.0) * (10 / steps) ** 2)
    assert verdict.how == FOUND and 1 <= verdict.steps / (100 * np.sqrt(1.2)) <= 1.1


def test_finer_steps_are_tried_where_steps_are_few():
    assert MadeUp(lambda steps, start: 1.0)._finer_ones(9) == [10, 11, 12, 13, 14, 15]


def test_a_start_that_needs_finer_steps_than_the_ladder_has_makes_it_climb():
    """The finest rung of the ladder keeps the error from the given start only."""
    made_up, verdict = searched(lambda steps, start: (30.0 if start < 1 else 1.0) * (10 / steps) ** 2)
    assert verdict.how == FOUND and 1 <= verdict.steps / (100 * np.sqrt(30.0)) <= 1.1
    assert made_up.rungs[-1] > 400


def test_coarser_steps_that_keep_the_error_by_accident_are_counted():
    _, verdict = searched(lambda steps, start: 1e-6 if steps in (32, 64) else (40 / steps) ** 2)
    assert verdict.how == FOUND and verdict.accidents == 2
