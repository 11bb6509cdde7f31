"""Evaluations of a run, counted by hand."""

import jax.numpy as jnp
import numpy as np
import pytest

import study

NAMES = ["force_evaluations", "tangent_evaluations", "factorisations"]


def _counts(problem, scheme, **options) -> list[int]:
    ds = study.run(problem, scheme, observe=["effort", "newton_iterations"], **options)
    return [int(ds[name]) for name in (*NAMES, "newton_iterations")]


def test_an_explicit_step_takes_a_force_and_no_matrix():
    assert _counts("hardening", "central_difference", dt=0.0075, steps=10) == [1 + 10, 0, 0, 0]
    assert _counts("hardening", "rk4", dt=0.0075, steps=10) == [4 * 10, 0, 0, 0]


def test_a_newton_iteration_takes_force_tangent_and_factorisation():
    forces, *counts, iterations = _counts("hardening", "average_acceleration", dt=0.0075, steps=10)
    assert forces == 1 + iterations and counts == [iterations] * 2


def test_an_explicit_scheme_that_iterates_for_the_velocity_counts_its_iterations():
    """On Duffing's equation with quadratic drag: the start and three iterations a step, without a further force."""
    duffing = study.Problem(lambda u, v: u + u**3 + 0.1 * v * jnp.abs(v), u0=1.0)
    forces, tangents, _, iterations = _counts(duffing, "central_difference", dt=0.1, steps=10)
    assert forces == 1 + iterations == 31 and tangents == 30


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["equal", "controlled"])
def test_the_matrix_of_a_linear_problem_is_new_when_the_step_size_changes(kind):
    springs = study.Problem(stiffness=np.array([[2.0, -1.0], [-1.0, 2.0]]), u0=[1.0, 0.0], v0=[0.1, 0.0])
    if kind == "equal":
        assert _counts(springs, "average_acceleration", dt=0.1, steps=10) == [1 + 10, 0, 1, 10]
        return
    options = {"tolerance": 1e-3, "duration": 10.0, "dt": 2.0, "observe": ["trajectory", "effort"]}
    ds = study.run(springs, "average_acceleration", **options)
    rejected = int(ds.steps_rejected_by_estimate)
    changes = 1 + np.count_nonzero(np.abs(np.diff(ds.step_size[1:])) > 1e-12)
    assert ds.factorisations == changes + rejected and rejected > 0
    # the scheme and the estimator both start with the acceleration at t = 0
    assert ds.force_evaluations == 2 + int(ds.steps) + rejected


@pytest.mark.slow
def test_estimates_and_rejected_steps_are_counted():
    """Step doubling takes three steps of four stages; the half-step residual takes one force more than a step."""
    pendulum = study.Problem(jnp.sin, u0=1.0, v0=0.5)
    ds = study.run(pendulum, "rk4", estimator="step_doubling", tolerance=1e-5, dt=2.0, duration=20.0, observe="effort")
    trials = int(ds.steps + ds.steps_rejected_by_estimate)
    assert ds.force_evaluations == 12 * trials and ds.steps_rejected_by_estimate > 0
    ds = study.run(
        pendulum, "central_difference", estimator="half_step_residual", tolerance=1e-2, duration=20.0, observe="effort"
    )
    assert ds.force_evaluations == 1 + 2 * int(ds.steps + ds.steps_rejected_by_estimate)


def test_lanes_count_their_own_evaluations():
    ds = study.run("hardening", "average_acceleration", dt=[0.0075, 0.001], steps=20, observe="effort")
    alone = [study.run("hardening", "average_acceleration", dt=dt, steps=20, observe="effort") for dt in ds.dt.values]
    for name in NAMES:
        np.testing.assert_array_equal(ds[name], [int(run[name]) for run in alone])


def test_the_exact_start_of_houbolt_is_counted():
    """1024 steps of Runge-Kutta for each of two earlier displacements, and the acceleration at t = 0."""
    forces, *_, iterations = _counts("hardening", study.Houbolt(start_by="exact"), dt=0.0075, steps=3)
    assert forces == 2 * 1024 * 4 + 1 + iterations


def test_a_correction_at_round_off_is_not_searched():
    """With several unknowns and a kink, an iteration evaluates the force once, and once where its correction leads."""
    springs = study.Problem(lambda u: u + jnp.where(jnp.abs(u) > 5.0, u**3, 0.1 * u**3), u0=[1.0, 0.5], v0=[0.0, 1.0])
    forces, tangents, _, iterations = _counts(springs, "average_acceleration", dt=0.1, steps=50)
    assert springs.kinked and tangents == iterations and forces == 1 + 2 * iterations
