"""Times of recommended steps."""

import itertools

import pytest

import study
from study.assessment import dataset


def test_a_slow_first_run_does_not_lengthen_the_time_of_a_scheme(monkeypatch):
    """The process is held up once, in the run whose time sets how many steps the timed runs have."""
    runs = itertools.count()

    class Busy:
        seconds_to_compile = 0.0

        def __init__(self, *_):
            pass

        def run(self, dt, steps):
            held_up = steps > 1 and next(runs) == 0
            return (0.05 if held_up else 1e-4 + 2e-8 * steps), True

    monkeypatch.setattr(dataset, "Timed", Busy)
    times = dataset.times_of_steps(study.Problem(force=lambda u: u, u0=1.0), study.schemes["rk4"], {0.1: 400})
    assert times[0.1][0] == pytest.approx(400 * 2e-8, rel=0.05)
