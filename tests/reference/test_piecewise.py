"""Exact motions in pieces, compared with formulas of textbooks and conserved quantities."""

import numpy as np
import pytest

import study
from reference import piecewise
from study import materials


def test_an_elastic_perfectly_plastic_mass_stops_where_its_energy_is_spent():
    """½ m v² = ½ p_y u_y + p_y (u − u_y) gives the largest u; the mass then oscillates about u − u_y by ± u_y."""
    k, py, v0 = 9.0, 3.0, 4.0
    problem = study.Problem(materials.elastoplastic(stiffness=k, yield_force=py), u0=0.0, v0=v0)
    t = np.linspace(1e-3, 10.0, 20_001)
    motion = piecewise.trajectory(problem, t)
    uy = py / k
    largest = uy + (v0**2 / 2 - py * uy / 2) / py
    assert motion.u.max() == pytest.approx(largest, rel=1e-7)
    assert motion.u[t > 4.0].min() == pytest.approx(largest - 2 * uy, rel=1e-6)
    assert motion.evaluations == 3


def test_a_mass_that_yields_by_two_millionths_is_seen_to_yield():
    beyond = 2e-6
    problem = study.Problem(materials.elastoplastic(stiffness=1.0, yield_force=1.0), u0=0.0, v0=1 + beyond)
    t = np.linspace(0.01, 2 * np.pi, 629)
    motion = piecewise.trajectory(problem, t, places=20_000)
    plastic = ((1 + beyond) ** 2 - 1) / 2
    assert motion.evaluations == 3
    assert motion.u[-1] == pytest.approx(plastic + np.cos(t[-1] - np.pi / 2), abs=1e-8)


def test_a_bouncing_mass_keeps_its_energy_and_its_period():
    k, g, height = 400.0, 9.81, 0.5
    problem = study.Problem(
        materials.gap(stiffness=k), u0=-height, load=study.GroundMotion([g, g], 1e3), title="bouncing"
    )
    sag = g / k
    speed = np.sqrt(2 * g * height)
    contact = 2 * (np.pi - np.arctan(speed / np.sqrt(k) / sag)) / np.sqrt(k)
    period = 2 * speed / g + contact
    motion = piecewise.trajectory(problem, period * np.arange(1, 11))
    assert motion.u == pytest.approx(np.full(10, -height), abs=1e-9)
    assert motion.v == pytest.approx(np.zeros(10), abs=1e-6)


def test_a_slipping_mass_stops_where_friction_has_spent_its_energy():
    """Coulomb friction as a stiff contact: a unit mass slips by v₀²/2 divided by the slip force."""
    problem = study.Problem(materials.friction(slip_force=2.0, stiffness=1e4), u0=0.0, v0=3.0)
    motion = piecewise.trajectory(problem, np.linspace(0.01, 5.0, 500))
    assert motion.u[-1] == pytest.approx(3.0**2 / 2 / 2.0, rel=1e-3)
    assert np.abs(motion.v[-100:]).max() < 0.03


@pytest.mark.slow
def test_under_a_record_schemes_converge_to_it():
    w = 2 * np.pi / 0.5
    spring = materials.elastoplastic(stiffness=w**2, yield_force=0.02 * w**2, hardening=0.05)
    problem = study.Problem(spring, u0=0.0, damping=0.1 * w, ground=study.GroundMotion.el_centro())
    exact = piecewise.trajectory(problem, np.arange(1, 501) * 0.02)
    assert exact.evaluations > 10
    errors = []
    for part in (4, 16):
        ds = study.run(problem, "average_acceleration", dt=0.02 / part, steps=500 * part, every=part)
        errors.append(np.abs(ds.u.values[1:] - exact.u).max() / np.abs(exact.u).max())
    assert errors[1] < errors[0] / 8 and errors[1] < 1e-3


def test_a_record_may_end_with_a_jump():
    problem = study.Problem(
        materials.elastoplastic(stiffness=10.0, yield_force=5.0), u0=0.0, ground=study.GroundMotion(np.ones(2), 1.0)
    )
    t = np.array([0.5, 1.0])
    assert piecewise.trajectory(problem, t).u == pytest.approx(-(1 - np.cos(np.sqrt(10) * t)) / 10, abs=1e-13)


@pytest.mark.parametrize(
    "problem, sentence",
    [
        (study.Problem(lambda u: u, u0=1.0, title="own"), "the spring of 'own' is not linear in pieces"),
        (
            study.Problem(materials.gap(stiffness=1.0), u0=1.0, load=lambda t: t, title="own"),
            "need the kinks of the load of 'own'",
        ),
        (study.Problem(lambda u: u, u0=[1.0, 2.0], title="own"), "'own' has 2 unknowns; exact pieces need one"),
    ],
)
def test_what_has_no_pieces_is_refused(problem, sentence):
    with pytest.raises(ValueError, match=sentence):
        piecewise.trajectory(problem, np.array([1.0]))
