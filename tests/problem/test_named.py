"""Named problems."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study


@pytest.mark.parametrize("name", ["stiff_soft", "stiff_soft_sine", "elastic_pendulum", "fpu_chain", "impact_bar"])
def test_forces_of_named_structures_are_slopes_of_their_energies(name):
    """The force along a random direction equals a central difference of the energy."""
    problem = study.problems[name]
    rng = np.random.default_rng(0)
    u, direction = rng.normal(size=(2, problem.u0.size)) / problem.u0.size
    energy, step = jax.jit(problem.potential), 1e-5
    slope = (energy(u + step * direction) - energy(u - step * direction)) / (2 * step)
    assert float(slope) == pytest.approx(float(problem.force(jnp.asarray(u)) @ direction), rel=1e-7)


@pytest.mark.parametrize("name", list(study.problems))
def test_a_problem_is_printed_as_its_equation(name):
    problem = study.problems[name]
    equation, start = repr(problem).splitlines()
    assert equation.startswith(f"{problem.title}: ") and ("f(t)" in equation) == (problem.load is not None)
    assert start.endswith(" unknowns") if np.ndim(problem.u0) else f"u(0) = {problem.u0}" in start
    assert ("C u̇" in equation) == (problem.damping is not None)
