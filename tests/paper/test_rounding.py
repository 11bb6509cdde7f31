"""Rounding once and twice."""

import pytest

from paper.published import printed_energy_errors
from paper.rounding import once, same, twice

PRINTED = printed_energy_errors()


@pytest.mark.parametrize(
    "value, rounded_once, rounded_twice",
    [(35.904, 35.9, 35.9), (39.4477, 39.4, 39.5), (0.0489, 0.0, 0.1), (7.05, 7.1, 7.1)],
)
def test_rounding(value, rounded_once, rounded_twice):
    value = PRINTED[0, 0, 0].copy(data=value)
    assert same(once(value), rounded_once) and same(twice(value), rounded_twice)
