"""Floors of round-off."""

import numpy as np
import pytest
import xarray as xr

import study
from study import datasets
from study.experiments.round_off import round_off


def _harmonic(steps, stretch=1.0, decay=0.0):
    """Reference of cos(2πt) as the pipeline writes it, and a problem that moves with another period and damping."""
    phase = np.linspace(0, 1, 64 * steps + 1)
    reference = xr.Dataset(
        {
            "u": ("t", np.cos(2 * np.pi * phase)),
            "v": ("t", -2 * np.pi * np.sin(2 * np.pi * phase)),
            "period": 1.0,
            "period_remainder": 0.0,
        },
        coords={"t": phase, "phase": ("t", phase)},
        attrs={"problem": "harmonic"},
    )
    omega = 2 * np.pi / stretch
    problem = study.Problem(
        lambda u: (omega**2 + decay**2) * u, u0=1.0, v0=-decay, damping=2 * decay if decay else None
    )
    return reference, problem


def test_round_off_asks_for_steps_that_meet_its_end(monkeypatch):
    reference, _ = _harmonic(8)
    monkeypatch.setattr(datasets, "open", lambda name: reference)
    with pytest.raises(ValueError, match=r"round_off.steps_per_period: 20 is no multiple of 8"):
        round_off("hardening", ["rk4"], [64, 20], 10)
    monkeypatch.setattr(datasets, "open", lambda name: reference.isel(t=slice(None, None, 100)))
    with pytest.raises(ValueError, match=r"the reference of 'hardening' lacks the phase 1/8; add 8 to"):
        round_off("hardening", ["rk4"], [64], 10)
