"""Explicit methods with a model of the structure: KR-α, MKR-α, Chen and Ricles', Chang's."""

import jax.numpy as jnp
import numpy as np
import pytest

import study


@pytest.mark.slow
@pytest.mark.parametrize(
    "scheme, factor, stable",
    [(1.0, 1.0, True), (1.0, 4.0, True), (1.0, 5.5, False), (0.8, 0.5, True), (0.8, 1.0, True), (0.8, 1.5, False)],
)
def test_stability_of_kr_alpha_is_that_of_its_model(scheme, factor, stable):
    """With ρ∞ = 1 stiffnesses up to 4/Δt² above the model's are stable; with ρ∞ = 0.8, only up to the model's."""
    dt, rest = 1.0, 1.0
    # a spring whose tangent is 1 at rest and `factor` away from it
    problem = study.Problem(lambda u: jnp.where(jnp.abs(u) < 1e-6, rest, factor) * u, u0=1.0)
    ds = study.run(problem, study.KolayRicles(rho_inf=scheme), dt=dt, steps=2000)
    assert (np.abs(ds.u).max() < 100) == stable


@pytest.mark.slow
@pytest.mark.parametrize("name", ["chen_ricles", "chang"])
@pytest.mark.parametrize("factor, stable", [(0.5, True), (4.99, True), (5.01, False)])
def test_stability_that_is_called_unconditional_ends_where_the_stiffness_has_risen(name, factor, stable):
    """The tangent may exceed the stiffness of the model by 4/Δt² at most, here by 4 with Δt = 1."""
    problem = study.Problem(lambda u: jnp.where(jnp.abs(u) < 1e-6, 1.0, factor) * u, u0=1.0)
    ds = study.run(problem, name, dt=1.0, steps=2000, on_failure="ignore")
    assert (np.abs(ds.u).max() < 1000) == stable


def test_changs_method_is_the_trapezoidal_rule_for_a_linear_structure():
    damped = {
        "mass": np.array([2.0, 1.0]),
        "damping": study.Rayleigh(a=0.1, b=0.05),
        "u0": [1.0, 0.5],
        "v0": [0.0, 2.0],
    }
    problem = study.Problem(stiffness=np.array([[6.0, -2.0], [-2.0, 4.0]]), **damped)
    chang, average = (study.run(problem, name, dt=0.5, steps=40) for name in ("chang", "average_acceleration"))
    np.testing.assert_allclose(chang.u, average.u, atol=1e-12)
    np.testing.assert_allclose(chang.v, average.v, atol=1e-12)


def test_both_methods_have_the_radius_of_their_parameter_at_infinite_frequency():
    """The roots at infinite frequency are −ρ∞ three times for KR-α, and −ρ∞ and ±iρ∞ for MKR-α."""
    for modified, roots in ((False, [-0.6] * 3), (True, [-0.6, 0.6j, -0.6j])):
        (matrix,) = study.LinearTheory(study.KolayRicles(rho_inf=0.6, modified=modified), np.array([1e7])).matrices
        np.testing.assert_allclose(np.poly(matrix), np.poly(roots), atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kr_alpha", "mkr_alpha", "chen_ricles"])
@pytest.mark.parametrize("drag, order", [(lambda v: 0.1 * v, 2), (lambda v: 0.3 * v * jnp.abs(v), 1)])
def test_the_order_from_the_lagged_velocity_needs_damping_that_is_linear(name, drag, order):
    """It alone catches that the lag of the velocity enters a drag force in every step, not only at the start."""
    problem = study.Problem(lambda u, v: u + u**3 + drag(v), 1.0, 0.5)
    acceleration = -(2.0 + float(drag(0.5)))
    exact = study.run(problem, "rk4", dt=0.001, steps=4000).u.values[-1]
    sizes = 0.01 / np.array([1, 2])
    starts = 0.5 - getattr(study.schemes[name], "velocity_lag") * sizes * acceleration  # noqa: B009
    steps = np.round(4 / sizes).astype(int)
    runs = [study.run(problem, name, dt=dt, steps=n, v0=v) for dt, n, v in zip(sizes, steps, starts, strict=True)]
    errors = [abs(ds.u.values[-1] - exact) for ds in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


def test_mkr_alpha_overshoots_less_than_kr_alpha_and_elongates_the_period_more():
    parts = np.array([1e-3, 1e-2, 0.1, 10.0])
    kolay, improved = (study.LinearTheory(name, parts) for name in ("kr_alpha", "mkr_alpha"))
    assert improved.overshoot()[0, -1] < 0.2 < 3 < kolay.overshoot()[0, -1]
    assert improved.motion().period_elongation[2] > 1.1 * kolay.motion().period_elongation[2] > 0
