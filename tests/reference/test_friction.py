"""Rigid Coulomb friction: the balance of its energy, and the limit of an elastic contact of growing stiffness."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from reference import piecewise, sundials
from study.assessment.reference import NoReference, Reference

T = np.linspace(0.0, 12.0, 2401)[1:]
MASS, STIFFNESS, SLIP = 2.0, 8.0, 0.7


def released(slip, u0, t):
    """Displacement and velocity of a mass released from rest on a spring with rigid friction.

        m ü + k u + F sgn u̇ = 0,    at rest where |k u| ≤ F

    Each half swing is harmonic about ∓F/k and takes π/ω. The amplitude falls by 2 F/k in each half swing, until the
    spring no longer overcomes the friction.

    Source: J. P. Den Hartog, Mechanical Vibrations, 4th edition, McGraw-Hill, 1956, section 7.5.
    """
    frequency, offset = np.sqrt(STIFFNESS / MASS), slip / STIFFNESS
    stuck = max(np.ceil((abs(u0) / offset - 1) / 2), 0.0) if offset else np.inf
    swing = np.minimum(np.floor(frequency * t / np.pi), stuck)
    side = np.sign(u0) * (-1) ** swing
    rest, phase = abs(u0) - 2 * swing * offset, frequency * t - np.pi * swing
    moves = swing < stuck
    u = side * np.where(moves, offset + (rest - offset) * np.cos(phase), rest)
    v = side * np.where(moves, -frequency * (rest - offset) * np.sin(phase), 0.0)
    return u, v


def test_the_energy_falls_by_the_slip_force_times_the_way():
    u, v = released(SLIP, -1.0, T)
    path = np.abs(np.diff(np.concatenate([[-1.0], u]))).cumsum()
    energy = MASS * v**2 / 2 + STIFFNESS * u**2 / 2
    assert energy == pytest.approx(STIFFNESS / 2 - SLIP * path, abs=1e-4)


def test_it_stops_where_the_spring_no_longer_overcomes_the_friction():
    u, v = released(SLIP, -1.0, T)
    assert (v[-100:] == 0).all() and np.ptp(u[-100:]) == 0
    assert abs(STIFFNESS * u[-1]) <= SLIP
    assert (released(SLIP, 0.99 * SLIP / STIFFNESS, T)[1] == 0).all()


def test_without_friction_it_swings_for_ever():
    assert released(0.0, 1.0, T)[0] == pytest.approx(np.cos(2 * T), abs=1e-12)


def contact(stiffness):
    """Problem of the spring parallel to an elastic contact that slips; together they are one elastoplastic spring."""
    total = STIFFNESS + stiffness
    spring = study.materials.elastoplastic(
        stiffness=total, yield_force=SLIP * total / stiffness, hardening=STIFFNESS / total
    )
    # the contact starts at its slip force, as if the mass had slipped to its start from farther out
    return study.Problem(spring, u0=1.0, history=1.0 + SLIP / stiffness, mass=MASS, title="contact")


@pytest.mark.slow
def test_a_stiff_contact_comes_near_it_with_the_root_of_its_stiffness():
    u, _ = released(SLIP, 1.0, T[:400])
    errors = [np.abs(piecewise.trajectory(contact(k), T[:400]).u - u).max() for k in (1e4, 1e6, 1e8)]
    assert errors[2] < 2e-5
    assert [errors[0] / errors[1], errors[1] / errors[2]] == pytest.approx([10, 10], rel=0.02)


def test_schemes_come_near_it_with_the_contact_of_the_study():
    slip = study.materials.friction(slip_force=SLIP, stiffness=1e5)

    def force(u, v, history):
        p, history = slip(u, v, history)
        return STIFFNESS * u + p, history

    problem = study.Problem(force, u0=1.0, history=1.0 + SLIP / 1e5, mass=MASS)
    expected, _ = released(SLIP, 1.0, T)
    ds = study.run(problem, "average_acceleration", dt=5e-4, steps=24_000, every=10)
    assert np.abs(ds.u.values[1:] - expected).max() < 3e-3
    assert np.abs(ds.u.values[1:] - piecewise.trajectory(contact(1e5), T).u).max() < 2e-5


def test_a_motion_that_sticks_is_refused_at_the_time_of_the_closed_form():
    """The motion sticks at the end of the last half swing, after π/ω for each reduction of the amplitude by 2 F/k."""
    swings = np.ceil((1.0 * STIFFNESS / SLIP - 1) / 2)
    end = swings * np.pi / np.sqrt(STIFFNESS / MASS)
    sentence = rf"switches without end from t = {end:.4g}: where dry friction sticks, .* as study.materials.friction is"
    rubbing = study.Problem(lambda u, v: STIFFNESS * u + SLIP * jnp.sign(v), u0=1.0, mass=MASS, title="rubbing")
    with pytest.raises(NoReference, match=sentence):
        Reference(rubbing, 12.0)


def test_a_motion_that_only_reverses_has_a_kink_at_each_reversal(capfd):
    problem = study.Problem(
        lambda u, v: 100 * u + 5 * jnp.sign(v), u0=1.0, load=lambda t: 600 * jnp.sin(5 * t), title="rubbing"
    )
    kinks = sundials.kinks(problem, 5.0, np.zeros(0))
    run = study.run(problem, "rk4", dt=1e-4, steps=50_000)
    v = run.v.values
    reversals = run.t.values[1:][v[1:] * v[:-1] < 0]
    np.testing.assert_allclose(kinks, reversals, atol=2e-4)
    assert "CVode" not in "".join(capfd.readouterr())
