"""Smooth hysteresis and fluid dampers: diffrax and CVODE compared with SciPy, with the schemes, and with each other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from reference.experiments import inelastic
from study.problem.inelastic import PERIOD


def _solved(problem, t):
    return inelastic.from_kink_to_kink(problem, t)[1]


T = np.arange(1, 17) * PERIOD / 8


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [1, 2])
def test_it_agrees_with_scipy_on_the_rate_equation(exponent):
    k, b, bound, damping = (2 * np.pi / PERIOD) ** 2, 0.05, 0.1, 0.25
    spring = study.materials.bouc_wen(stiffness=k, yield_force=k * bound, hardening=b, exponent=exponent)
    problem = study.Problem(spring, 0.0, 2.5, damping=damping, title="hysteretic")
    solution = _solved(problem, T)

    def rate(t, state):
        u, v, y = state
        force = b * k * u + (1 - b) * k * bound * y
        return v, -damping * v - force, v / bound * (1 - abs(y) ** exponent * (1 + np.sign(y * v)) / 2)

    options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "max_step": 0.002}
    expected = solve_ivp(rate, (0.0, T[-1]), [0.0, 2.5, 0.0], t_eval=T, **options)
    assert solution.u == pytest.approx(expected.y[0], abs=1e-8)
    assert solution.v == pytest.approx(expected.y[1], abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rk4", "average_acceleration"])
def test_schemes_converge_to_it(name):
    problem = study.problems["hysteretic"]
    expected = _solved(problem, T).u
    errors = [
        np.abs(study.run(problem, name, dt=PERIOD / n, steps=2 * n, every=n // 8).u.values[1:] - expected).max()
        for n in (256, 4096)
    ]
    assert errors[1] < errors[0] / 50 and errors[1] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 40])
def test_a_start_that_is_loaded_already(count):
    problem = study.Problem(study.materials.bouc_wen(stiffness=40.0, yield_force=4.0), u0=0.3)
    t = np.linspace(0, 0.8, count + 1)[1:]
    ds = study.run(problem, "rk4", dt=0.8 / 4000, steps=4000, every=4000 // count)
    assert _solved(problem, t).u == pytest.approx(ds.u.values[1:], abs=1e-7)


def damped(exponent):
    damper = study.materials.viscous_damper(coefficient=1.0, exponent=exponent)
    return study.Problem(lambda u, v: 40 * u + damper(u, v), u0=1.0, title="damped")


@pytest.mark.slow
@pytest.mark.parametrize(
    "problem", [study.problems["hysteretic"], damped(0.5), damped(1.5)], ids=lambda problem: problem.title
)
def test_both_solvers_agree(problem):
    _, first, second = inelastic.from_kink_to_kink(problem, T)
    assert first.u == pytest.approx(second.u, abs=1e-11)
    assert first.v == pytest.approx(second.v, abs=1e-10)


@pytest.mark.slow
def test_schemes_converge_to_the_motion_of_a_damper():
    expected = _solved(damped(0.5), T).u
    errors = []
    for n in (64, 1024):
        ds = study.run(damped(0.5), "average_acceleration", dt=1 / n, steps=2 * n, every=n // 8)
        errors.append(np.abs(ds.u.values[1:] - expected).max())
    assert errors[1] < errors[0] / 100 and errors[1] < 1e-4


@pytest.mark.slow
def test_the_pulse_has_a_closed_form():
    """The reference equals the forced motion up to the end of the half sine, and the free motion afterwards."""
    omega, end = 2 * np.pi / PERIOD, 0.2
    r = np.pi / (omega * end)

    def forced(t):
        u = (np.sin(np.pi * t / end) - r * np.sin(omega * t)) / (1 - r**2)
        return u, r * omega * (np.cos(np.pi * t / end) - np.cos(omega * t)) / (1 - r**2)

    (u, v), elapsed = forced(end), T - end
    free = u * np.cos(omega * elapsed) + v / omega * np.sin(omega * elapsed)
    expected = np.where(T < end, forced(T)[0], free)
    ds = inelastic.inelastic(["pulse"], 2, 8)
    assert ds.u.values[0] == pytest.approx(expected, abs=1e-11)


@pytest.mark.slow
def test_the_references_are_certain_to_many_digits():
    """A kink or an event that one of the two solvers passes over."""
    ds = inelastic.inelastic(["hardening", "yielding", "hysteretic", "bouncing", "shaken", "pulse"], 2, 8)
    assert ds.u.shape == (6, 16) and np.isfinite(ds.u).all()
    assert (ds.u_uncertainty < 1e-9).all()
