"""The search for the largest step size that keeps an error, with made-up errors."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import study
from study.assessment.search import COARSEST_KEEPS, FINEST_FAILS, FOUND, STARTS
from study.assessment.steps import LEAST_CONFIRMED, StepSearch, finest_step, round_step, spacing
from study.sizes import TWENTIETH


class MadeUp(StepSearch):
    """A search whose errors come from a function of step size and start instead of runs."""

    def __init__(self, error, finest=1e-5, spacing=None, unknowns=1):
        self.duration, self.coarsest, self.finest, self._unknowns, self._spacing = 20.0, 1.0, finest, unknowns, spacing
        self._error, self.runs = error, pd.DataFrame()
        self._cases = dict.fromkeys((1.0, *STARTS))  # type: ignore[assignment]
        self._random, self._long = np.random.default_rng(1), 30_000
        self._end, self.late, self.compiling = math.inf, False, 0.0

    def _run(self, start, dt):
        dt = np.atleast_1d(dt)
        errors = [self._error(step, start) for step in dt]
        return pd.DataFrame({"start": start, "dt": dt, "u": errors, "steps": self.duration // dt, "forces": np.nan})


def searched(error, allowed=0.01, **options):
    made_up = MadeUp(error, **options)
    made_up.search([("u", allowed)])
    return made_up, made_up.verdict("u", allowed)


def _tried_up_to(made_up, step):
    unscaled = made_up.runs[made_up.runs.start == 1.0]
    return unscaled[(unscaled.dt <= step) & (unscaled.dt >= TWENTIETH * step)]


@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_the_step_of_a_regular_error_is_found(order):
    made_up, verdict = searched(lambda dt, start: start * dt**order)
    exact = 0.01 ** (1 / order)
    assert verdict.how == FOUND and 0.9 * exact <= verdict.largest <= exact
    assert 0.81 * exact <= verdict.recommended <= verdict.largest
    assert verdict.recommended == float(f"{verdict.recommended:.1e}")
    assert verdict.tried == len(_tried_up_to(made_up, verdict.recommended)) > 100
    assert made_up.runs.dt.min() < 1.3 * TWENTIETH * verdict.recommended


def test_a_lucky_step_is_passed_over():
    """A narrow band of step sizes has small errors, at all starts or at one start; the search does not recommend it."""
    for lucky in (lambda start: True, lambda start: start == 1.0):
        _, verdict = searched(lambda dt, start, lucky=lucky: 1e-6 if lucky(start) and 0.3 < dt < 0.5 else dt**2)
        assert verdict.how == FOUND and 0.085 < verdict.largest < 0.1


def test_an_unlucky_stretch_of_steps_is_found():
    """The step sizes from 0.050 to 0.051 are a hundredth of the range up to 0.1; the search finds that they fail."""
    _, verdict = searched(lambda dt, start: 0.02 if 0.050 < dt < 0.051 else dt**2)
    assert verdict.recommended <= 0.05


def test_errors_that_scatter_keep_a_larger_distance():
    """One error in a hundred exceeds five times the median, yet less than one new step in a thousand fails."""

    def error(dt, start):
        return dt * np.random.default_rng(int(dt * 2**60)).lognormal(sigma=0.7)

    _, verdict = searched(error)
    fresh = verdict.recommended * np.random.default_rng(7).uniform(TWENTIETH, 1.0, 10_000)
    assert verdict.largest_error < 0.6 * 0.01 and np.mean([error(dt, 1.0) > 0.01 for dt in fresh]) < 0.001


def test_a_start_that_needs_finer_steps_sets_the_recommended_one():
    made_up, verdict = searched(lambda dt, start: (30.0 if start < 1 else 1.0) * dt**2)
    exact = np.sqrt(0.01 / 30)
    assert verdict.how == FOUND and 0.9 * exact <= verdict.recommended <= exact
    assert _tried_up_to(made_up, verdict.recommended).dt.min() < 1.3 * TWENTIETH * verdict.recommended


def test_the_ends_of_a_search_are_said_as_such():
    assert searched(lambda dt, start: 1e-5 * dt)[1].how == COARSEST_KEEPS
    for constant in (0.5, np.nan):
        assert searched(lambda dt, start, c=constant: c, finest=1e-3)[1].how == FINEST_FAILS
    for unknowns in (1, 1000):
        neighbours = searched(lambda dt, start: 1e-5 if start == 1.0 else 1.0, finest=1e-3, unknowns=unknowns)
        assert neighbours[1].how == FINEST_FAILS


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(
    order=st.floats(0.5, 4),
    bumps=st.lists(st.tuples(st.floats(-8.0, 0.0), st.floats(0.001, 1000)), max_size=8),
    allowed=st.lists(st.floats(1e-3, 0.3), min_size=1, max_size=3),
)
def test_all_that_was_tried_below_a_recommended_step_keeps_the_error(order, bumps, allowed):
    """All runs at the recommended step and at finer steps keep the error, for any curve of errors."""

    def error(dt, start):
        factor = np.prod([size for place, size in bumps if abs(np.log2(dt) - place) < 0.1], initial=1.0)
        return factor * start * dt**order

    made_up = MadeUp(error, finest=1e-4)
    made_up.search([("u", limit) for limit in allowed])
    for limit in allowed:
        verdict = made_up.verdict("u", limit)
        if verdict.recommended > 0:
            finer = made_up.runs[made_up.runs.dt <= verdict.recommended]
            assert (finer.u <= limit).all() and verdict.largest_error <= limit
            assert set(finer[finer.dt == verdict.recommended].start) == {1.0, *STARTS}


@pytest.mark.parametrize(
    "largest, between_samples, expected",
    [
        (0.02131, None, 0.021),
        (0.21, None, 0.21),
        (9.99, None, 9.9),
        (1.0e-5, None, 1.0e-5),
        (0.02131, 0.02, 0.02),
        (0.065, 0.02, 0.06),
        (0.0199, 0.02, 0.01),
        (0.0091, 0.02, 0.02 / 3),
        (0.0031, 0.02, 0.02 / 7),
        (0.005, 0.02, 0.005),
        (0.003, 1 / 128, 1 / 384),
    ],
)
def test_a_round_step_is_one_that_an_engineer_writes(largest, between_samples, expected):
    assert round_step(largest, between_samples) == pytest.approx(expected, rel=1e-12)


def test_a_step_of_a_large_structure_is_confirmed_by_several_others():
    made_up, verdict = searched(lambda dt, start: dt, allowed=0.01, finest=0.005, unknowns=1000)
    step = verdict.recommended
    assert verdict.how == FOUND and verdict.tried == len(_tried_up_to(made_up, step)) > LEAST_CONFIRMED[False]


def test_stiff_modes_take_a_search_to_finer_steps_as_far_as_their_work_allows():
    # a run of 3 s with 150 unknowns, whose periods range from 3 s to 0.03 s
    assert finest_step(3.0, 3.0, 200.0, 150) == pytest.approx(0.03 / 200)
    # for one unknown the limit of 250,000 steps × unknowns decides
    assert finest_step(3.0, 3.0, 2.0, 1) == finest_step(3.0, 3.0, 1e6, 1) == 3.0 / 250_000
    # for 1000 unknowns with a stiff mode the cap of 4,000,000 steps × unknowns decides
    assert finest_step(3.0, 3.0, 1e6, 1000) == 3.0 / 4000


def test_the_spacing_of_a_record_is_found_in_the_load():
    ground = study.GroundMotion(np.sin(np.arange(100)), 0.02)
    assert spacing(study.Problem(lambda u: u, 0.0, ground=ground), 1.0) == pytest.approx(0.02)
    assert spacing(study.Problem(lambda u: u, 0.0, ground=study.GroundMotion(np.ones(2), 10.0)), 1.0) is None
    assert spacing(study.problems["hardening"], 1.0) is None
