"""Loads of problems."""

import jax.numpy as jnp
import pytest

import study
from study.mechanics.loads import excited, restarted


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


def test_another_start_of_a_bouncing_mass_is_another_motion():
    """Height and gravity multiplied by one factor would only scale the motion."""
    bouncing, pendulum, pulse = (study.problems[name] for name in ("bouncing", "elastic_pendulum", "pulse"))
    higher = restarted(bouncing, 1.05)
    assert higher.u0 == 1.05 * bouncing.u0 and higher.ground(0.0) == bouncing.ground(0.0)
    # the stiff bar of the pendulum keeps its length
    assert (restarted(pendulum, 1.05).u0 == pendulum.u0).all() and (restarted(pendulum, 1.05).v0 != pendulum.v0).any()
    assert restarted(pulse, 1.05).load(0.1) == pytest.approx(1.05 * pulse.load(0.1))
