"""Round-off over long times."""

from fractions import Fraction

import numpy as np
import pytest
import xarray as xr

import study
from study.experiments import long_times as experiment
from tests.references import cosine

OMEGA = 2 * np.pi
HARMONIC = study.Problem(lambda u: OMEGA**2 * u, potential=lambda u: OMEGA**2 * u * u / 2, u0=1.0, title="harmonic")


def test_the_round_off_is_that_of_a_random_walk(monkeypatch):
    monkeypatch.setattr(experiment.io, "open_dataset", lambda name: cosine(1))
    monkeypatch.setattr(experiment, "problems_by_name", {"hardening": HARMONIC})
    ds = experiment.long_times("hardening", ["central_difference"], 20, [10, 100, 1000], 16).squeeze()
    # the square root of the number of steps times the unit round-off, with a factor of the order of one
    walk = np.finfo(float).eps * np.sqrt(20 * ds.periods)
    assert (0.05 * walk < ds.energy_round_off).all() and (ds.energy_round_off < walk).all()
    # the period of a linear motion does not depend on its energy, so the phase is a random walk too
    assert [ds.energy_exponent.item(), ds.phase_exponent.item()] == pytest.approx([0.5, 0.5], abs=0.2)


def _crossings(count: int, step: list[int], part: list[float]) -> xr.Dataset:
    values = {"crossings": [count] * len(step), "last_crossing_step": step, "last_crossing_part": part}
    return xr.Dataset({name: ("run", value) for name, value in values.items()})


def test_the_delay_is_that_of_the_mean_period():
    """The tenth crossing of a motion with T̄ = 1.01 T, which begins three quarters of a period before the first one."""
    dt, time = np.array([0.05, 0.04]), 9.75 * 1.01
    step = (time / dt).astype(int)
    ds = _crossings(10, step.tolist(), (time / dt - step).tolist())
    assert experiment._delay(ds, dt, 12, Fraction(1), Fraction(3, 4)) == pytest.approx([0.12, 0.12], rel=1e-12)
    assert np.isnan(experiment._delay(_crossings(0, [0], [0.0]), dt[:1], 12, Fraction(1), Fraction(3, 4))).all()
