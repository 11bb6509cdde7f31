"""Sentences on the reliability of an assessment."""

import math

from study.assessment.assurance import confirmation, other_durations
from tests import small_results


def test_few_tries_are_no_assurance():
    ds = small_results.assessment().assign_attrs(starts="")
    assert "at most 0.429\u00a0% of such steps exceed the allowed error." in confirmation(ds)
    ds.steps_tried[0, 0, 0] = 3
    text = confirmation(ds)
    assert "at most 0.429\u00a0% of such steps" in text and "100\u00a0%" not in text
    assert "1 of 7 recommended steps were confirmed by fewer than 30 steps, which is no assurance" in text
    ds.steps_tried[:] = 3
    assert "With 95 %" not in confirmation(ds)


def test_steps_over_longer_durations_follow_the_law_for_free_vibration_only():
    ds = small_results.assessment().assign_coords(order=("scheme", [2, 4]), order_of_loss=("scheme", [math.inf, 5]))
    free = other_durations(ds.assign_attrs(free_vibration=1))
    assert "falls with n^(−0.4) with Central difference; n^(−0.5) with Average acceleration." in free
    forced = other_durations(ds.assign_attrs(free_vibration=0))
    assert forced == "All steps hold for 10 s. A longer duration needs an assessment of its own."
