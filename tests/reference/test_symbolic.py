"""The translation of a JAX function for the solvers."""

import inspect
import re

import heyoka as hy
import jax.numpy as jnp
import numpy as np
import pytest

import study
from reference.symbolic import as_python, expression, first_order, with_force_as_state
from study.problem.springs import CubicSpring


def test_every_route_solves_the_same_constants():
    """All translations hold the constants of the problem in full double precision."""
    problem = study.Problem(CubicSpring(100.0, 10.0).force, u0=0.1, damping=1 / 3, mass=1.0000000000000047)
    states, (_, rate) = ["u", "v"], first_order(problem)[1]
    u, v = hy.make_vars(*states)
    compiled, python = hy.cfunc([rate], [u, v]), as_python(problem)
    for point in np.random.default_rng(2).uniform(-1, 1, (20, 2)):
        assert python(0.0, *point) == pytest.approx(compiled(point)[0], rel=1e-15, abs=0)
    constants = [float(number) for number in re.findall(r"\d+\.\d+", inspect.getsource(python))]
    assert 1 / 3 / 1.0000000000000047 == pytest.approx(constants[-1], rel=2e-16, abs=0)


def test_translation_keeps_the_function():
    """A JAX function and its heyoka expression agree on random arguments."""
    u = hy.make_vars("u")
    for function in (
        study.problems["softening"].force,
        lambda x: jnp.sin(x) * jnp.exp(-(x**2)) / (2.0 + jnp.cos(3.0 * x)),
        lambda x: x**3 - 0.5 * x + jnp.sqrt(1.0 + x * x),
        lambda x: jnp.arctan(x) + jnp.log1p(x * x) * jnp.arcsinh(x) + jnp.expm1(-x) * jnp.tan(x / 2),
    ):
        compiled = hy.cfunc([expression(function, u)], [u])
        for x in np.random.default_rng(0).uniform(-2, 2, 20):
            assert compiled(np.array([x]))[0] == pytest.approx(float(function(x)), rel=1e-13)


def test_forces_that_are_not_smooth_are_refused():
    with pytest.raises(ValueError, match="'abs' has no translation"):
        first_order(study.Problem(lambda u: jnp.abs(u) * u, u0=1.0))
    with pytest.raises(ValueError, match="has 2 unknowns"):
        first_order(study.Problem(lambda u: u, u0=[1.0, 2.0], v0=[0.0, 0.0]))


def test_the_second_formulation_does_not_evaluate_the_force():
    (_, _), (_, acceleration), (_, _) = with_force_as_state(study.problems["softening"])
    assert "tanh" not in str(acceleration)
    assert "tanh" in str(first_order(study.problems["softening"])[1][1])
