"""What the reference says about a quantity."""

import numpy as np
import pytest

import study
from study.assessment import errors, solution


def _peak(problem, duration, of):
    kinks = solution.kinks_of(problem, duration)
    grid = solution.grid_of(problem, duration, duration / 20, kinks)
    exactly = solution.solution_by(solution.routes_of(problem, duration, kinks)[0], problem, grid, 1e-12)
    return errors.target(study.Quantity(of, reduce="peak"), problem, exactly).value


def test_a_peak_at_a_kink_of_the_ground_motion_is_not_rounded_off():
    # under a ground acceleration that rises from 0 to 1 m/s² in a second, and falls again: ü(1) = −sin(ω)/ω
    omega = 0.1
    ground = study.GroundMotion(np.array([0.0, 1.0, 0.0]), 1.0)
    soft = study.Problem(lambda u: omega**2 * u, 0.0, ground=ground)
    assert _peak(soft, 2.0, lambda a: a) == pytest.approx([np.sin(omega) / omega], rel=1e-9)


def test_a_peak_between_the_points_of_the_reference_is_found():
    # components u = cos(t) and 2 cos(t) of different phase: u₀ = (1, 0), u̇₀ = (0, 2)
    two = study.Problem(lambda u: u, np.array([0.5, 0.0]), v0=np.array([1.0, 2.0]))
    assert _peak(two, 6.0, lambda u: u) == pytest.approx([np.hypot(0.5, 1.0), 2.0], rel=1e-8)
