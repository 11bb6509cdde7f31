"""Causes of mistakes that are made by hand: of the output, of the time, of the iteration and of a weight."""

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from conformance import runners
from conformance.command import cases
from conformance.examples import newmark
from conformance.judge import judge, judged, times
from conformance.problem import Problem

BY_NAME = {case["name"]: case for case in cases()}
TEXT = Path(newmark.__file__).read_text(encoding="utf-8")


def _judged(name, step=newmark.step, change=lambda u, v, a, dt: (u, v, a), load=None):
    """Verdict on a program in NumPy with a change of its output or of its load."""
    case = BY_NAME[name]
    problem, (dt, steps) = Problem(case["problem"]), times(case)
    if load is not None:
        right = problem.load
        problem.load = lambda t: right(load(t, dt))  # type: ignore[method-assign]
    motion = dict(zip("uva", change(*step(problem, case["scheme"], dt, steps), dt), strict=True))
    return judge(case, lambda part: motion)


def _central(move):
    """Central difference of one linear oscillator, from a function that makes a step."""

    def step(problem, scheme, dt, steps):
        m, c, k = (x.item() for x in (problem.mass, problem.damping, problem.tangent(problem.u0)))

        def a(t, u, v):
            return (problem.load(t).item() - c * v - k * u) / m

        t, u, v = 0.0, problem.u0.item(), problem.v0.item()
        rows, kept = [(u, v, a(t, u, v))], None
        for size in np.broadcast_to(dt, steps).tolist():
            *row, kept = move(a, t, size, *rows[-1], kept)
            rows.append(tuple(row))
            t += size
        return [np.array(rows)[:, [i]] for i in range(3)]

    return step


@_central
def _predicted(a, t, dt, u, v, a0, kept):
    """The formulas of fedoo 1.1.0."""
    u1 = u + dt * v - dt**2 / 2 * a0 + dt**2 * a(t + dt, u, v)
    a1 = a(t + dt, u1, v + dt * a0)
    return u1, v + dt / 2 * (a0 + a1), a1, None


@_central
def _late(a, t, dt, u, v, a0, half):
    """The formulas of Kratos 10.4.4; ``half`` is the velocity of the half step before."""
    acceleration = a(t + dt, u, v)
    v = v if half is None else half + dt / 2 * acceleration
    half = v + dt / 2 * acceleration
    return u + dt * half, v, acceleration, half


@pytest.mark.parametrize(
    ("change", "cause", "where"),
    [
        (
            lambda u, v, a, dt: (u, np.vstack([v[:1], v[:-1]]), a),
            "the velocity is one step late",
            "u agrees, v differs",
        ),
        (
            lambda u, v, a, dt: (u, np.vstack([v[:1], np.diff(u, axis=0) / dt]), a),
            "the velocity is that of half a step before, (u₁ − u₀)/Δt",
            "u agrees, v differs from step 1 on, a agrees",
        ),
        (lambda u, v, a, dt: (np.vstack([u[:1], u[:-1]]), v, a), "the displacement is one step late", "v agrees"),
        (
            lambda u, v, a, dt: [np.vstack([x[:1], x[:-1]]) for x in (u, v, a)],
            "values are right but one step late",
            "u differs from step 1 on, v differs from step 1 on, a differs from step 1 on",
        ),
        (
            lambda u, v, a, dt: (u, v, 0 * a),
            "displacement and velocity agree; the acceleration is not the one that the scheme carries",
            "u agrees, v agrees, a differs from step 0 on",
        ),
    ],
)
def test_a_mistake_of_the_output_is_named(change, cause, where):
    verdict = _judged("A-CUB-AVG", change=change)
    assert verdict.cause == cause and where in verdict.where


@pytest.mark.parametrize(
    ("load", "cause"),
    [
        (lambda t, dt: t + dt, "the time of the load starts at 1 Δt"),
        (lambda t, dt: t + 0.7 * dt, "the time of the load starts at 0.7 Δt"),
        (lambda t, dt: t + dt / 2 if t else t, "each load is that of 0.5 Δt later"),
    ],
)
def test_a_time_that_starts_elsewhere_is_named(load, cause):
    assert _judged("A-LIN-HHT", load=load).cause == cause


@pytest.mark.parametrize(
    ("name", "old", "new", "cause"),
    [
        ("A-CUB-AVG", "range(50)", "range(2)", "Newton's iteration stops after 2 iterations"),
        (
            "A-LIN-DIS",
            "part * v_new + alpha_f * v",
            "0.3 * v_new + 0.7 * v",
            "the term 1 − α_f in C v has the factor 0.3",
        ),
        ("A-LIN-GEN", "(1 - alpha_m) * new + alpha_m * a", "new", "α_m is missing in the balance"),
        (
            "A-CUB-DIS",
            "v_ahead = v + tau * (1 - gamma) * a",
            "v_ahead = v",
            "(1 − γ) a₀ in the velocity, for the balance",
        ),
        ("A-CUB-HHT", "dt**2 * ((0.5 - beta) * a", "dt * ((0.5 - beta) * a", "has the factor 1/Δt"),
        ("A-CUB-DIS", "gamma * tau * new", "beta * tau * new", "has the factor β/γ"),
        (
            "A-LIN-GEN",
            "part = 1 - alpha_f",
            "part = 1",
            "1 − α_f in the balance, for the end of the step alone has the factor 1/(1 − α_f)",
        ),
        (
            "A-LIN-HHT",
            "problem.load(t + part * tau)",
            "problem.load(t - part * tau)",
            "1 − α_f in f(t) has the factor -1",
        ),
        (
            "A-CUB-WIL",
            "(new - a) / theta",
            "new / theta",
            "a₀/θ in the interpolation of the acceleration has the factor 0",
        ),
        ("A-CUB-DIS", "tau * (1 - gamma) * a", "tau * (1 - beta) * a", "has the factor (1 − β)/(1 − γ)"),
        ("A-LIN-CDM", 'numbers.get("gamma", 0.5)', 'numbers.get("gamma", 0.4)', "gamma is off by about -0.1"),
        ("A-LIN-CDM", "load - C @ v_ahead - ", "load - ", "v₀ + Δt (1 − γ) a₀ in the velocity, for the balance alone"),
    ],
)
def test_a_mistake_in_a_formula_is_named(name, old, new, cause):
    module: Any = ModuleType("mistaken")
    assert TEXT.count(old) == 1
    exec(TEXT.replace(old, new), module.__dict__)
    assert cause in _judged(name, module.step).cause


@pytest.mark.parametrize(
    ("name", "first", "second", "cause"),
    [
        ("A-CUB-DIS", "beta", "gamma", "β and γ are exchanged"),
        ("A-LIN-GEN", "alpha_m", "alpha_f", "α_m and α_f are exchanged"),
    ],
)
def test_exchanged_parameters_are_named(name, first, second, cause):
    def exchanged(problem, scheme, dt, steps):
        return newmark.step(problem, {**scheme, first: scheme[second], second: scheme[first]}, dt, steps)

    assert _judged(name, exchanged).cause == cause


def test_a_mistake_has_one_name_in_all_cases():
    """With β = ¼ and γ = ½ the factor γ/β is 2; the other case has β = 0.3025 and γ = 0.6."""
    module: Any = ModuleType("mistaken")
    exec(TEXT.replace("/ (beta * tau**2)", "/ (gamma * tau**2)"), module.__dict__)
    for names in (("A-CUB-AVG", "A-CUB-DIS"), ("A-CUB-DIS", "A-CUB-AVG")):
        verdicts = judged([BY_NAME[name] for name in names], runners.step_runner(module.step))
        assert [verdict.name for verdict in verdicts] == [*names]
        assert {verdict.cause for verdict in verdicts} == {
            "the term Δt² β a₁ in the displacement, for the balance alone has the factor γ/β"
        }


@pytest.mark.parametrize(
    ("name", "step", "cause"),
    [
        ("D-HARM-CDM", _predicted, "the damping acts on the velocity v₀ + Δt a₀, and the displacement takes the load"),
        ("G-HARM-CDM", _late, "the load is taken one step too late, and the velocity, also that of the damping"),
    ],
)
def test_central_difference_in_the_form_of_two_codes_is_named(name, step, cause):
    assert cause in _judged(name, step).cause


def test_a_large_error_of_a_parameter_is_not_named_by_its_derivative():
    """In this case a multiple of the derivative by α_m fits the wrong values, but no error of α_m gives them."""
    module: Any = ModuleType("mistaken")
    exec(TEXT.replace("(x - u_ahead) / (beta", "(x + u_ahead) / (beta", 1), module.__dict__)
    assert _judged("A-CUB-WBZ", module.step).cause == "not known"


@pytest.mark.filterwarnings("error")
def test_huge_values_have_a_verdict_without_a_warning():
    verdict = _judged("A-CUB-AVG", change=lambda u, v, a, dt: (1e300 * u, 1e300 * v, a))
    assert (verdict.verdict, verdict.cause) == ("fail", "not known")


def test_a_cause_that_explains_no_value_is_not_named():
    """A random velocity is no change of the scheme."""
    noise = np.random.default_rng(1).normal(size=(3, 1))
    verdict = _judged("A-CUB-AVG", change=lambda u, v, a, dt: (u, v + noise, a))
    assert (verdict.verdict, verdict.cause, verdict.where) == (
        "fail",
        "not known",
        "u agrees, v differs from step 0 on, a agrees",
    )
