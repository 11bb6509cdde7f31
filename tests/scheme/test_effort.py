"""The counted forces of a step, compared with the calls that a step makes."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
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


def _problem(kind: str, calls: list[float]) -> study.Problem:
    """The problem, whose force and potential add an entry to ``calls`` each time that they are evaluated."""

    def counted(function):
        def call(u):
            jax.debug.callback(lambda u: calls.append(float(np.abs(u).max())), u)
            return function

        return call

    force, u0 = KINDS[kind]
    called = counted(force)
    if kind == "with a history":
        return study.Problem(lambda u, v, history: called(u)(u, v, history), u0, history=0.0)
    if kind == "p(u, v)":
        return study.Problem(lambda u, v: called(u)(u, v), u0, v0=[-1.0, 1.0])
    potential = counted(lambda u: jnp.sum(50 * u**2 + 250 * u**4))
    return study.Problem(lambda u: called(u)(u), u0, potential=(lambda u: potential(u)(u)) if "p(u)" in kind else None)


def _check(
    scheme: study.Scheme, kind: str, dt: float = 0.01, prepared=lambda problem: problem
) -> study.building.Effort:
    calls: list[float] = []
    problem = prepared(_problem(kind, calls))
    if reason := scheme.refusal(problem):
        pytest.skip(reason)
    marched = WithHistory(scheme) if problem.history is not None else scheme
    # without compilation, every evaluation of the force runs its callback
    with jax.disable_jit():
        state, _ = started(marched, problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), jnp.asarray(dt))
        jax.effects_barrier()
        calls.clear()
        _, effort = stepped(marched, problem, state, jnp.zeros(()), jnp.asarray(dt))
        jax.effects_barrier()
    # the model of some explicit schemes is the tangent at u = 0, which is the same in every step
    assert sum(x > 0 for x in calls) == int(effort.forces) > 0
    return effort


@pytest.mark.parametrize("scheme", [study.schemes[name] for name in ("bathe", "central_difference", "kr_alpha")])
@pytest.mark.parametrize("kind", KINDS)
def test_the_forces_of_every_kind_are_counted(scheme, kind):
    _check(scheme, kind)


@pytest.mark.parametrize("kind", ["p(u, v)"])
def test_the_forces_of_every_scheme_are_counted(scheme, kind):
    _check(scheme, kind)
