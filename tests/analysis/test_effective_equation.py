"""Roots of the effective equation of a step."""

import jax.numpy as jnp
import pytest

import study
from study.analysis.effective_equation import effective_coefficient


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["average_acceleration", "newmark_dissipative", "hht_alpha_1996", "wilson_theta", "houbolt"]
)
def test_the_coefficient_of_the_effective_equation_is_where_a_step_is_singular(name):
    scheme, dt = study.schemes[name], 0.7
    kappa = effective_coefficient(scheme)

    def size_of_step(stiffness):
        problem = study.Problem(lambda u: stiffness * u, 1.0, 0.3)
        state, _ = study.schemes["average_acceleration"].start(problem, jnp.asarray(1.0), jnp.asarray(0.3), dt)
        if name == "houbolt":
            state, _ = scheme.start(study.Problem(lambda u: 0 * u, 1.0, 0.3), jnp.asarray(1.0), jnp.asarray(0.3), dt)
        return abs(float(scheme.step(problem, state, 0.0, dt)[0].u))

    singular = -1 / (kappa * dt**2)
    assert size_of_step(singular * (1 + 1e-9)) > 1e6 > size_of_step(singular * 1.1)


def test_schemes_of_several_equations_have_no_coefficient():
    with pytest.raises(ValueError, match=r"a step of 'Bathe' is not one effective equation"):
        effective_coefficient(study.schemes["bathe"])
