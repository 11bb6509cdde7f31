"""Floors of round-off."""

import pytest

from study import io
from study.experiments.round_off import round_off


def test_round_off_requires_steps_that_meet_its_end(cosine, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: cosine)
    with pytest.raises(ValueError, match=r"round_off.steps_per_period: 20 is not a multiple of 8"):
        round_off("hardening", ["rk4"], [64, 20], 10)
    monkeypatch.setattr(io, "open_dataset", lambda name: cosine.isel(t=slice(None, None, 100)))
    with pytest.raises(ValueError, match=r"the reference of 'hardening' lacks the phase 1/8; add 8 to"):
        round_off("hardening", ["rk4"], [64], 10)
