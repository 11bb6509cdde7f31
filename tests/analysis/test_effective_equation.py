"""Roots of the effective equation of a step."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import study
from study.analysis.effective_equation import effective_coefficient, number_of_roots
from study.problem.springs import CubicSpring


@given(
    S1=st.floats(-5, 5).filter(lambda x: abs(x) > 0.1),
    S2=st.floats(-2, 2).filter(lambda x: abs(x) > 1e-3),
    c=st.floats(0.01, 10),
    predictor=st.floats(-1, 1),
)
@example(S1=1.0, S2=-0.25, c=1.0, predictor=0.0)
@settings(max_examples=40, deadline=None)
def test_roots_of_a_cubic_effective_equation(S1, S2, c, predictor):
    spring = CubicSpring(S1, S2)
    exact = np.roots([c * S1 * S2, 0, 1 + c * S1, -predictor])
    real = exact[np.abs(exact.imag) < 1e-9].real
    apart = np.diff(np.sort(real))
    # the search may miss roots beyond 3.9, or two roots closer than 0.01; such equations are left out
    if len(real) and np.abs(real).max() < 3.9 and (not len(apart) or apart.min() > 0.01):
        found = number_of_roots(study.Problem(spring.force, 1.0, 0.0), np.array([c]), np.array([predictor, 1.0, -1.0]))
        assert found[0, 0] == len(real)


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
