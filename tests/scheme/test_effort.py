"""The counted forces of a step, compared with the calls that a step makes."""

from collections.abc import Callable
from contextlib import nullcontext

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.analysis.forces import forces_of
from study.building import Effort
from study.scheme.contract import started, stepped
from study.scheme.wrapper.with_history import WithHistory


def _with_history(u, v, history):
    elastic = jnp.clip(u - history, -0.5, 0.5)
    return 100 * u + 50 * elastic, u - elastic


#: Force and initial displacement of problems of each kind.
KINDS: dict[str, tuple[Callable, float | list[float]]] = {
    "p(u)": (lambda u: 100 * u + 1000 * u**3, [1.5, 1.0]),
    "p(u), one unknown": (lambda u: 100 * u + 1000 * u**3, 1.5),
    "p(u, v)": (lambda u, v: 100 * u + 1000 * u**3 + v * jnp.sqrt(1 + v * v), [1.5, 1.0]),
    "with a kink": (lambda u: 100 * u + jnp.where(u > 1.5, 1e6 * (u - 1.5), 0.0), [1.5, 1.0]),
    "with a kink, one unknown": (lambda u: 100 * u + jnp.where(u > 1.5, 1e6 * (u - 1.5), 0.0), 1.5),
    "with a history": (_with_history, 1.5),
}
SATURATING = {
    "that saturates": (lambda u: 100 * jnp.arctan(10 * u), [1.5, 1.0]),
    "that saturates, one unknown": (lambda u: 100 * jnp.arctan(10 * u), 1.5),
}


def _problem(kind: str, calls: list[float]) -> study.Problem:
    """The problem, whose force and potential add an entry to ``calls`` each time that they are evaluated."""

    def counted(function):
        def call(u):
            jax.debug.callback(lambda u: calls.append(float(np.abs(u).max())), u)
            return function

        return call

    force, u0 = (KINDS | SATURATING)[kind]
    called = counted(force)
    if kind == "with a history":
        return study.Problem(lambda u, v, history: called(u)(u, v, history), u0, history=0.0)
    if kind == "p(u, v)":
        return study.Problem(lambda u, v: called(u)(u, v), u0, v0=[-1.0, 1.0])
    potential = counted(lambda u: jnp.sum(50 * u**2 + 250 * u**4))
    return study.Problem(lambda u: called(u)(u), u0, potential=(lambda u: potential(u)(u)) if "p(u)" in kind else None)


def _check(scheme: study.Scheme, problem: study.Problem, calls: list[float], dt: float = 0.01) -> Effort:
    if reason := scheme.refusal(problem):
        pytest.skip(reason)
    marched = WithHistory(scheme=scheme) if problem.history is not None else scheme
    # the start is not compiled, because every evaluation of the force then runs its callback at once
    with jax.disable_jit():
        state, _ = started(marched, problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), jnp.asarray(dt))
        jax.effects_barrier()
    calls.clear()
    # a safeguard has a loop within a loop, whose condition JAX evaluates too often without compilation
    with nullcontext() if problem.safeguarded else jax.disable_jit():
        _, effort = jax.jit(lambda state: stepped(marched, problem, state, jnp.zeros(()), jnp.asarray(dt)))(state)
        jax.effects_barrier()
    # the model of some explicit schemes is the tangent at u = 0, which is the same in every step
    assert sum(x > 0 for x in calls) == int(effort.forces) > 0
    return effort


def _counted(scheme: study.Scheme, kind: str, **options) -> Effort:
    calls: list[float] = []
    return _check(scheme, _problem(kind, calls), calls, **options)


@pytest.mark.slow
def test_the_forces_of_every_class_of_schemes_are_counted(kind):
    _counted(study.schemes[kind], "p(u), one unknown")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["central_difference", "generalized_alpha"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_forces_of_every_kind_are_counted(name, kind):
    _counted(study.schemes[name], kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["that saturates", "that saturates, one unknown"])
def test_the_forces_of_a_safeguard_are_counted(kind):
    calls: list[float] = []
    effort = _check(study.schemes["average_acceleration"], _problem(kind, calls).with_safeguard(), calls, dt=10.0)
    assert effort.restarts == 1 and effort.converged


def test_a_discrete_gradient_needs_fewer_forces_with_one_unknown():
    scheme = study.schemes["energy_momentum"]
    assert forces_of(scheme) == (1, 2) and forces_of(scheme, several=False) == (1, 1)
    ds = study.run("hardening", scheme, dt=0.01, steps=100, observe=["effort", "newton_iterations"])
    # one more at the start
    assert ds.force_evaluations == 1 + 100 + ds.newton_iterations


def test_the_force_that_corrects_an_acceleration_is_counted():
    _counted(study.UnequalSteps(scheme=study.schemes["generalized_alpha"], correction="balance"), "p(u), one unknown")
