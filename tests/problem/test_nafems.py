"""Benchmarks of NAFEMS, whose modes have a closed form."""

import numpy as np
import pytest

import study
from study.problem import nafems
from study.problem.named import known


def _middle(name, u):
    """Displacement in the middle of the structure."""
    weights = known[name].weights
    assert weights is not None
    return u @ weights[0]


def _peak(name):
    """Largest displacement in the middle of the structure, and the time at which it is reached."""
    ds = study.run(name, "gauss4", dt=known[name].time / 400, steps=600)
    middle = _middle(name, ds.u.values)
    return middle.max(), ds.t.values[middle.argmax()]


@pytest.mark.slow
def test_the_deep_beam_has_the_printed_frequency_and_peak():
    problem = study.problems["deep_beam"]
    mass = np.sqrt(np.asarray(problem.mass))
    first = np.linalg.eigvalsh(np.asarray(problem.stiffness) / np.outer(mass, mass))[0]
    assert np.sqrt(first) / (2 * np.pi) == pytest.approx(42.649, rel=2e-4)
    peak, time = _peak("deep_beam")
    assert peak == pytest.approx(1.043e-3, rel=1e-3) and time == pytest.approx(0.0117, abs=5e-5)


@pytest.mark.slow
def test_the_printed_peak_of_the_thin_plate_is_that_of_its_first_mode():
    problem, target = study.problems["thin_plate"], known["thin_plate"]
    stiffness, mass, damping = (np.asarray(matrix)[0] for matrix in (problem.stiffness, problem.mass, problem.damping))
    frequency = np.sqrt(stiffness / mass)
    assert frequency / (2 * np.pi) == pytest.approx(2.377, abs=5e-4)
    ratio = damping / (2 * mass * frequency)
    static = problem.load(0.0)[0] / stiffness
    assert static == pytest.approx(1.817e-3, rel=3e-4)
    first = static * (1 + np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)))
    assert first == pytest.approx(target.u[0], rel=3e-4)
    # the source prints times in steps of 0.002 s
    peak, time = _peak("thin_plate")
    assert peak == pytest.approx((1 - 0.018) * target.u[0], rel=1e-3) and time == pytest.approx(0.210, abs=1e-3)


def test_static_deflections_are_those_of_all_modes():
    """The beam deflects by 5qL⁴/(384EI) + qL²/(8κGA), and the plate by 0.00406 qL⁴/D.

    The deflection of the plate is that of Timoshenko and Woinowsky-Krieger.
    """
    young, length = nafems.YOUNG, nafems.LENGTH
    beam = study.problems["deep_beam"]
    middle = _middle("deep_beam", np.linalg.solve(np.asarray(beam.stiffness), np.asarray(beam.load(0.0))))
    shear = 0.85 * young / 2.6 * 4
    assert middle == pytest.approx(5e6 * length**4 / (384 * young * 4 / 3) + 1e6 * length**2 / (8 * shear), rel=1e-3)
    plate = study.problems["thin_plate"]
    middle = _middle("thin_plate", np.asarray(plate.load(0.0)) / np.asarray(plate.stiffness))
    assert middle == pytest.approx(0.00406 * 100 * length**4 * 12 * 0.91 / (young * 0.05**3), rel=1e-3)
