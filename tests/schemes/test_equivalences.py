"""Schemes that become each other at certain parameters, and parameters that are refused."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import study
from study.problems import CubicSpring
from study.schemes.houbolt import starts


def _trajectory(scheme, problem="hardening", dt=0.15 / 40, steps=200):
    return study.run(problem, scheme, dt=dt, steps=steps).u.values


@pytest.mark.parametrize(
    "one, other",
    [
        (study.HHTAlpha(alpha=0.0, beta=0.25, gamma=0.5), study.Newmark(beta=0.25, gamma=0.5)),
        (study.HHTAlpha(alpha=0.0, beta=0.3025, gamma=0.6), study.Newmark(beta=0.3025, gamma=0.6)),
        (study.WilsonTheta(theta=1.0), study.Newmark(beta=1 / 6, gamma=0.5)),
        (study.WilsonTheta(theta=1.0, beta=0.25, gamma=0.5), study.Newmark(beta=0.25, gamma=0.5)),
    ],
    ids=["α = 0", "α = 0, dissipative", "θ = 1, linear acceleration", "θ = 1, average acceleration"],
)
@pytest.mark.parametrize("problem", ["hardening", "softening"])
def test_limits(one, other, problem):
    dt = {"hardening": 0.15, "softening": 1.14}[problem] / 40
    np.testing.assert_allclose(_trajectory(one, problem, dt), _trajectory(other, problem, dt), rtol=0, atol=1e-11)


def test_newmark_with_beta_zero_is_central_difference():
    """uₙ₊₁ − 2uₙ + uₙ₋₁ = −Δt² p(uₙ), written out with NumPy."""
    dt, steps = 0.15 / 40, 200
    force = CubicSpring(100.0, 10.0).force
    u = [1.5, 1.5 - dt**2 / 2 * force(1.5)]
    for _ in range(steps - 1):
        u.append(2 * u[-1] - u[-2] - dt**2 * force(u[-1]))
    np.testing.assert_allclose(_trajectory("central_difference", dt=dt, steps=steps), u, rtol=0, atol=1e-10)


def test_central_difference_enters_no_iteration():
    ds = study.run("hardening", "central_difference", dt=0.001, steps=10, observe=["newton_iterations"])
    assert ds.newton_iterations == 0


def test_houbolt_starts_with_the_linear_acceleration_method():
    dt = 0.15 / 20
    houbolt, linear = (_trajectory(s, dt=dt, steps=1) for s in (study.Houbolt(), study.Newmark(beta=1 / 6, gamma=0.5)))
    np.testing.assert_allclose(houbolt, linear, rtol=1e-13)


@pytest.mark.parametrize("damping", [None, 3.0])
def test_houbolt_started_by_central_difference_takes_two_of_its_steps(damping):
    problem = study.Problem(CubicSpring(100.0, 10.0).force, u0=1.5, v0=2.0, damping=damping)
    dt = 0.15 / 20
    houbolt = _trajectory(study.Houbolt(start_by="central_difference"), problem, dt, 2)
    np.testing.assert_allclose(houbolt, _trajectory("central_difference", problem, dt, 2), rtol=1e-12)


@pytest.mark.parametrize("start", starts)
def test_every_start_of_houbolt_keeps_the_second_order(start):
    period = 0.151532834447260357127078726219
    errors = [
        abs(study.run("hardening", study.Houbolt(start_by=start), dt=period / 4 / n, steps=n).u.values[-1])
        for n in (800, 1600, 3200)
    ]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2, abs=0.1)


def test_exact_start_of_houbolt_is_exact():
    """Backwards from rest the motion is that forwards."""
    problem, dt = study.problems["hardening"], 0.15 / 20
    u_1, u_2, _ = starts["exact"](problem, jnp.asarray(1.5), jnp.asarray(0.0), dt)
    fine = study.run(problem, "rk4", dt=dt / 512, steps=1024, every=512).u.values
    np.testing.assert_allclose([u_1, u_2], fine[1:], rtol=1e-11)


def test_alpha_method_of_1996_weights_two_forces():
    """(1 + α) p(u₁) − α p(u₀), not p at the weighted displacement: the step satisfies eq. (12) with the former."""
    scheme, dt = study.schemes["hht_alpha"], 0.15 / 20
    force = study.problems["hardening"].force
    ds = study.run("hardening", scheme, dt=dt, steps=1)
    u0, u1 = ds.u.values
    a0 = -force(u0)
    a1 = (u1 - u0 - dt**2 * (0.5 - scheme.beta) * a0) / (scheme.beta * dt**2)
    two_forces = (1 + scheme.alpha) * force(u1) - scheme.alpha * force(u0)
    one_force = force((1 + scheme.alpha) * u1 - scheme.alpha * u0)
    assert a1 == pytest.approx(-two_forces, rel=1e-10)
    assert abs(a1 + one_force) > 1e-3 * abs(a1)


@pytest.mark.parametrize(
    "make, name",
    [
        (lambda x: study.Newmark(beta=x, gamma=0.5), "beta"),
        (lambda x: study.Newmark(beta=0.25, gamma=x), "gamma"),
        (lambda x: study.WilsonTheta(theta=x), "theta"),
        (lambda x: study.HHTAlpha(alpha=x, beta=0.3025, gamma=0.6), "alpha"),
        (lambda x: study.HHTAlpha(alpha=-0.1, beta=x, gamma=0.6), "beta"),
    ],
)
@pytest.mark.parametrize("value", [-0.5, float("nan"), float("inf"), "a", None, [0.25], 1j, np.array([0.25, 0.3])])
def test_parameters_out_of_range_are_refused(make, name, value):
    with pytest.raises(ValueError, match=rf"{name}=.*{name} must be"):
        make(value)


def test_an_unknown_start_is_refused_with_the_nearest():
    with pytest.raises(ValueError, match="did you mean 'taylor'"):
        study.Houbolt(start_by="tailor")


@settings(max_examples=25, deadline=None)
@given(
    stiffness=st.floats(0.5, 200.0),
    cubic=st.floats(0.0, 5.0),
    u0=st.floats(-2.0, 2.0),
    part=st.floats(0.002, 0.02),
)
def test_energy_of_faithful_schemes_stays_near(stiffness, cubic, u0, part):
    """On random hardening springs the energy error of both faithful schemes is O(Δt²) and does not grow."""
    spring = CubicSpring(stiffness, cubic)
    problem = study.Problem(spring.force, u0=u0 if abs(u0) > 1e-3 else 1.0, potential=spring.potential)
    fastest = np.sqrt(stiffness * (1 + 3 * cubic * 4))
    dt = 2 * np.pi * part / fastest
    for scheme in ("average_acceleration", "central_difference"):
        ds = study.run(problem, scheme, dt=dt, steps=2000, observe=["max_energy_error"])
        assert ds.status == 0
        assert ds.max_energy_error < 100 * (fastest * dt) ** 2
