"""Times of recommended steps."""

import itertools

import pandas as pd
import pytest
import xarray as xr

import study
from study.assessment import dataset
from study.assessment.search import FOUND, Verdict


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
    times = dataset.times_of_steps(Busy(), {0.1: 400})
    assert times[0.1][0] == pytest.approx(400 * 2e-8, rel=0.05)


def test_a_slow_second_of_the_machine_lengthens_the_times_of_no_scheme_alone(monkeypatch):
    """All runs of the scheme that is timed first are three times as long, as long as the others were not timed."""
    met = set()

    class Slow:
        def __init__(self, _, scheme, *__):
            self.scheme = scheme

        def run(self, _, steps):
            met.add(self.scheme)
            return (3 if met == {"first"} else 1) * 1e-6 * steps, True

    monkeypatch.setattr(dataset, "Timed", Slow)
    runs = pd.DataFrame({"dt": [0.1], "steps": [4000]})
    verdicts = {("displacement", 0.01): Verdict(FOUND, 0.1, 0.1, steps=4000)}
    results = {name: dataset.Assessed(runs, verdicts, xr.Dataset()) for name in ("first", "second")}
    times = dataset._times(study.Problem(force=lambda u: u, u0=1.0), {name: name for name in results}, results)
    assert times["first"] == times["second"]
