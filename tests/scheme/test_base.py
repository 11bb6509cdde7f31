"""Declared properties of schemes."""

from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study


def test_forces_are_counted(scheme):
    """The declared number of evaluations equals the counted calls of force and potential in a step."""
    calls: list[jax.Array] = []

    def counted(function):
        def call(u):
            jax.debug.callback(calls.append, u)
            return function(u)

        return call

    force, potential = counted(lambda u: 100 * u + 1000 * u**3), counted(lambda u: (50 * u**2 + 250 * u**4).sum())
    problem = study.Problem(force, u0=[1.5, 1.0], v0=[0.0, 0.0], potential=potential)
    state, _ = scheme.start(problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), jnp.asarray(1e-3))
    jax.effects_barrier()
    calls.clear()
    _, effort = scheme.step(problem, state, 0.0, jnp.asarray(1e-3))
    jax.effects_barrier()
    # evaluations at u = 0 are left out: they give the model of KR-α, which is the same in every step
    evaluated = [u for u in calls if np.any(u)]
    assert len(evaluated) == scheme.forces_per_step + int(effort.iterations) * scheme.forces_per_iteration


def test_the_force_that_corrects_an_acceleration_is_counted():
    test_forces_are_counted(study.UnequalSteps(scheme=study.schemes["generalized_alpha"], correction="balance"))


def test_a_scheme_is_printed_in_a_few_lines_with_order_limit_and_source(scheme):
    lines = repr(scheme).splitlines()
    assert len(lines) == 4 and max(map(len, lines)) <= 130
    assert lines[0].startswith(f"{scheme.title}: ") and lines[1].startswith(f"{type(scheme).__name__}(")
    assert f"order {scheme.order}" in lines[2] and "stable" in lines[2] and scheme.source in lines[3]


def test_a_scheme_that_states_little_is_printed_too():
    class Bare(study.OneStep):
        title: str = "bare"
        source: ClassVar[str] = "nobody (2000)"
        doi: ClassVar[str] = ""
        order = 1
        explicit = True
        start = increment = lambda self, *arguments: None  # type: ignore[assignment]

    assert repr(Bare()) == "bare\nBare()\nexplicit, order 1\nsource: nobody (2000)"


def test_a_class_without_source_is_told_what_to_define():
    class Unsourced(study.OneStep):
        title: str = "unsourced"
        order = 1
        explicit = True
        increment = lambda self, *arguments: None  # type: ignore[assignment]  # noqa: E731

    with pytest.raises(TypeError) as error:
        Unsourced()  # type: ignore[abstract]
    assert str(error.value) == (
        "Unsourced is a scheme and must define doi (Digital object identifier of the source, empty if it has none) and "
        "source (Author and year of the first publication)."
    )


def test_a_limit_of_zero_that_a_class_states_is_not_warned_about():
    stated = study.schemes["dormand_prince6"]
    assert study.Compensated(scheme=stated).stability_limit == stated.stability_limit == 0
