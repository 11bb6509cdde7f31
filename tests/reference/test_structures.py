"""Solvers with step size control on several unknowns, compared with each other and with modes in closed form."""

from collections.abc import Callable

import numpy as np
import pytest

import reference.diffrax
import study
from reference import closed_form, sundials
from reference.experiments.structures import structure_reference
from study.problem.named import time_scales

RTOL = 1e-10
TRAJECTORIES: list[Callable] = [sundials.trajectory, reference.diffrax.trajectory]


@pytest.mark.slow
def test_two_solvers_agree_on_a_stiff_chain():
    problem = study.problems["fpu_chain"]
    t = np.linspace(0, time_scales["fpu_chain"], 9)
    first, second = (trajectory(problem, t, RTOL) for trajectory in TRAJECTORIES)
    np.testing.assert_allclose(first.u, second.u, atol=1e-6)
    # in the stiff springs, velocities are fifty times as large as displacements
    np.testing.assert_allclose(first.v, second.v, atol=5e-5)
    energy = [float(problem.energy(u, v)) for u, v in zip(first.u, first.v, strict=True)]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


@pytest.mark.parametrize("name", closed_form.STRUCTURE_TRAJECTORIES)
def test_closed_forms_solve_the_equation_of_motion(name):
    """The closed form satisfies the equation of motion, checked by central differences, and the initial conditions."""
    problem, h = study.problems[name], 1e-6
    t = np.array([0.3, 1.1, 2.7])
    u, _ = closed_form.structure_trajectory(name, problem, t)
    (_, before), (_, after) = (closed_form.structure_trajectory(name, problem, t + shift) for shift in (-h, h))
    forces = np.stack([problem.force(displacement) for displacement in u])
    loads = 0.0 if problem.load is None else np.stack([problem.load(time) for time in t])
    np.testing.assert_allclose((after - before) / (2 * h) + forces, loads, atol=1e-6 * np.abs(forces).max())
    start, speed = closed_form.structure_trajectory(name, problem, [0.0])
    np.testing.assert_allclose(start[0], problem.u0, atol=1e-15)
    np.testing.assert_allclose(speed[0], problem.v0, atol=1e-15)


def test_the_period_of_the_pendulum_is_the_printed_one():
    problem, quarter = study.problems["pendulum"], time_scales["pendulum"] / 4
    u, v = closed_form.structure_trajectory("pendulum", problem, [quarter - 1e-3, quarter, quarter + 1e-3])
    assert v[0] > v[1] > v[2] and abs(u[1] - u.max()) < 1e-9


@pytest.mark.parametrize("name, route, witness", [
    ("stiff_soft", "closed form", "diffrax Dopri8"), ("duffing_periodic", "diffrax Dopri8", "CVODE Adams"),
])  # fmt: skip
def test_the_error_bar_is_the_difference_of_the_best_two_routes(name, route, witness):
    ds = structure_reference(name, periods=0.3, samples_per_period=10, rtol=1e-9)
    assert (ds.route, ds.witness) == (route, witness)
    loose = structure_reference(name, periods=0.3, samples_per_period=10, rtol=1e-6)
    assert 0 < ds.u_uncertainty.max() < 1e-6 and ds.u_uncertainty.max() < loose.u_uncertainty.max()
    if route == "closed form":
        np.testing.assert_array_equal(ds.u, loose.u)


MASS = np.array([[2.0, 0.5], [0.5, 1.0]])
STIFFNESS = np.array([[6.0, -2.0], [-2.0, 4.0]])
U0, V0 = np.array([1.0, 0.0]), np.array([0.0, 2.0])


def _modes(t):
    """Displacement Σ φ (φᵀ M u₀ cos ωt + φᵀ M u̇₀ sin ωt / ω) with φᵀ M φ = 1, and its velocity."""
    root = np.linalg.inv(np.linalg.cholesky(MASS))
    squares, vectors = np.linalg.eigh(root @ STIFFNESS @ root.T)
    omega, shapes = np.sqrt(squares), root.T @ vectors
    c, s = np.cos(np.multiply.outer(t, omega)), np.sin(np.multiply.outer(t, omega))
    amplitudes, speed = shapes.T @ MASS @ U0, shapes.T @ MASS @ V0
    return (amplitudes * c + speed / omega * s) @ shapes.T, (speed * c - amplitudes * omega * s) @ shapes.T


@pytest.mark.parametrize("trajectory", TRAJECTORIES, ids=["CVODE", "diffrax"])
def test_coupled_oscillators_move_in_their_modes(trajectory):
    """Two unknowns that are coupled by the mass matrix and the stiffness."""
    problem = study.Problem(lambda u: STIFFNESS @ u, U0, V0, mass=MASS)
    t = np.linspace(0.5, 10, 20)
    solution = trajectory(problem, t, RTOL)
    u, v = _modes(t)
    np.testing.assert_allclose(solution.u, u, atol=1e-7)
    np.testing.assert_allclose(solution.v, v, atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("trajectory", TRAJECTORIES, ids=["CVODE", "diffrax"])
def test_a_mass_held_as_a_band_is_the_same_as_a_matrix(trajectory):
    """Nine pairs of the coupled oscillators, whose mass matrix is held as a band, move like a single pair."""
    n = 9
    mass, stiffness = np.kron(np.eye(n), MASS), np.kron(np.eye(n), STIFFNESS)
    problem = study.Problem(lambda u: stiffness @ u, np.tile(U0, n), np.tile(V0, n), mass=mass, tangent="tridiagonal")
    t = np.array([1.0, 2.0])
    np.testing.assert_allclose(trajectory(problem, t, RTOL).u, np.tile(_modes(t)[0], n), atol=1e-7)


@pytest.mark.parametrize("mass", [[1.0, 0.0], [[1.0, 1.0], [1.0, 1.0]]], ids=["diagonal", "matrix"])
@pytest.mark.parametrize("route, trajectory", list(zip(["CVODE Adams", "diffrax Dopri8"], TRAJECTORIES, strict=True)))
def test_a_singular_mass_is_refused(mass, route, trajectory):
    problem = study.Problem(lambda u: STIFFNESS @ u, U0, V0, mass=mass, title="bent")
    with pytest.raises(ValueError, match=f"the mass of 'bent' is singular, which {route} cannot solve"):
        trajectory(problem, np.array([1.0]), RTOL)
