"""The limit on the wall time of a reference."""

import math
import threading
import time

import numpy as np
import pytest

import study
from reference import sundials
from reference.solution import ENDS
from study.assessment.deadline import OutOfTime, within


def test_work_in_time_has_its_result_and_its_error():
    for end in (math.inf, time.monotonic() + 60):
        assert within(end, lambda: 3, "late") == 3
        with pytest.raises(ZeroDivisionError):
            within(end, lambda: 1 / 0, "late")


def test_work_that_is_late_is_given_up():
    stop, start = threading.Event(), time.monotonic()
    with pytest.raises(OutOfTime, match="too late"):
        within(start + 0.1, lambda: stop.wait(60), "too late")
    assert time.monotonic() - start < 30
    stop.set()


def test_cvode_ends_itself_when_the_time_is_over():
    # 160,000 periods, of which none is finished
    fast = study.Problem(lambda u: 1e6 * u, 1.0)
    token = ENDS.set(time.monotonic())
    try:
        with pytest.raises(TimeoutError):
            sundials.trajectory(fast, np.array([1.0, 500.0, 1000.0]), 1e-10)
    finally:
        ENDS.reset(token)
