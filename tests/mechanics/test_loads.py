"""Loads of problems."""

import jax.numpy as jnp
import pytest

import study
from study.mechanics.loads import excited


def test_an_excitation_scales_velocity_and_load():
    pendulum, duffing = (study.problems[name] for name in ("pendulum", "duffing_chaotic"))
    assert excited(pendulum, 0.5).v0 == 0.5 * pendulum.v0 and excited(pendulum, 0.5).load is None
    t = jnp.asarray(0.3)
    assert excited(duffing, 3.0).load(t) == pytest.approx(3 * duffing.load(t))
    assert excited(duffing, 3.0).u0 == duffing.u0


def test_an_excitation_scales_the_ground_that_quantities_read():
    shaken, t = study.problems["shaken"], jnp.asarray(2.0)
    assert excited(shaken, 3.0).ground(t) == pytest.approx(3 * shaken.ground(t)) != 0
    assert excited(shaken, 3.0).load(t) == pytest.approx(3 * shaken.load(t))
