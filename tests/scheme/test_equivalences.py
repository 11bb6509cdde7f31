"""Schemes that are equal at certain parameters, and schemes compared with their formulas."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import study
from study.problem.springs import CubicSpring
from study.scheme.alpha import hht_alpha_1996
from study.scheme.backward_differences import bdf2, park
from study.scheme.bathe import tr_bdf2
from study.scheme.explicit_alpha import chung_lee

VELOCITY_VERLET = study.Composition(weights=(1.0,), order_without_damping=2)


def _trajectory(scheme, problem="hardening", dt=0.15 / 40, steps=200):
    return study.run(problem, scheme, dt=dt, steps=steps).u.values


@pytest.mark.slow
@pytest.mark.parametrize(
    "scheme, limit",
    [
        (study.HHTAlpha1996(alpha=0.0, beta=0.25, gamma=0.5), study.Newmark(beta=0.25, gamma=0.5)),
        (study.HHTAlpha1996(alpha=0.0, beta=0.3025, gamma=0.6), study.Newmark(beta=0.3025, gamma=0.6)),
        (study.WilsonTheta(theta=1.0), study.Newmark(beta=1 / 6, gamma=0.5)),
        (study.WilsonTheta(theta=1.0, beta=0.25, gamma=0.5), study.Newmark(beta=0.25, gamma=0.5)),
        (study.GeneralizedAlpha(alpha_m=0.0, alpha_f=0.0, beta=0.25, gamma=0.5), study.Newmark(beta=0.25, gamma=0.5)),
        (study.GeneralizedAlpha.hht(rho_inf=1.0), study.Newmark(beta=0.25, gamma=0.5)),
        (study.GeneralizedAlpha.wbz(rho_inf=1.0), study.Newmark(beta=0.25, gamma=0.5)),
        (study.AverageVectorField(points=1), study.ImplicitMidpoint()),
        (VELOCITY_VERLET, study.schemes["central_difference"]),
        (study.KickDriftKick(kicks=(0.5, 0.5), drifts=(1.0,), order_without_damping=2), VELOCITY_VERLET),
        (study.Extrapolation(sequence=(1,)), VELOCITY_VERLET),
        (study.TchamwaWielgosz(phi=1.0), study.schemes["symplectic_euler"]),
        (study.SingleSolve(rho_s=0.0, rho_b=1.0), study.schemes["central_difference"]),
        (study.BetaBathe(beta1=1 / 3, beta2=2 / 3), study.schemes["bathe"]),
        (study.BetaBathe(beta1=3 / 7, beta2=4 / 7), study.Bathe(gamma=0.5, rho_inf=0.5)),
        (study.TwoStep(rho_inf=0.0), bdf2),
        (study.TwoStep(rho_inf=1.0), study.schemes["average_acceleration"]),
    ],
    ids=[
        "α = 0",
        "α = 0, dissipative",
        "θ = 1, linear acceleration",
        "θ = 1, average acceleration",
        "α_m = α_f = 0",
        "HHT of ρ∞ = 1",
        "WBZ of ρ∞ = 1",
        "one point of Gauss",
        "velocity Verlet is central difference",
        "two kicks and a drift",
        "nothing to extrapolate",
        "φ = 1",
        "GSSE without dissipation",
        "β₁ = ⅓, β₂ = ⅔",
        "β₁ + β₂ = 1",
        "two-step method of ρ∞ = 0",
        "two-step method of ρ∞ = 1",
    ],
)
@pytest.mark.parametrize("problem", ["hardening", pytest.param("softening", marks=pytest.mark.exhaustive)])
def test_limits(scheme, limit, problem):
    dt = {"hardening": 0.15, "softening": 1.14}[problem] / 40
    np.testing.assert_allclose(_trajectory(scheme, problem, dt), _trajectory(limit, problem, dt), rtol=0, atol=1e-11)


def test_velocity_verlet_is_registered_once():
    """``velocity_verlet`` is an alias of central difference; the composition equals it with damping and a load too."""
    assert study.schemes["velocity_verlet"] is study.schemes["central_difference"]
    assert "velocity_verlet" not in list(study.schemes)
    problem = study.Problem(
        CubicSpring(100.0, 10.0).force, u0=1.5, v0=2.0, damping=3.0, load=lambda t: 50 * jnp.sin(9 * t)
    )
    composed, central = (_trajectory(scheme, problem, 0.15 / 40) for scheme in (VELOCITY_VERLET, "central_difference"))
    np.testing.assert_allclose(composed, central, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("problem, dt", [("hardening", 0.15 / 40), ("softening", 1.14 / 40)])
@pytest.mark.parametrize(
    "once, twice",
    [
        (study.Bathe(gamma=0.5, rho_inf=1.0), "average_acceleration"),
        (study.NohBathe(p=0.5), "central_difference"),
    ],
)
def test_two_equal_sub_steps_are_two_steps(once, twice, problem, dt):
    trajectory = _trajectory(once, problem, dt, 100)
    np.testing.assert_allclose(trajectory, _trajectory(twice, problem, dt / 2, 200)[::2], rtol=0, atol=1e-11)


def test_tr_bdf2_is_as_bank_and_others_print_it():
    """Second stage as a backward difference: y₁ = [y_γ − (1 − γ)² y₀]/(γ(2 − γ)) + (1 − γ)/(2 − γ) Δt ẏ₁."""
    dt = 0.15 / 40
    g, force = tr_bdf2.gamma, study.problems["hardening"].force
    assert g == pytest.approx(2 - np.sqrt(2))
    half = study.run("hardening", "average_acceleration", dt=g * dt, steps=1).isel(t=1)
    whole = study.run("hardening", tr_bdf2, dt=dt, steps=1).isel(t=1)
    old = np.array([1.5, 0.0])
    middle, new = (np.array([ds.u.item(), ds.v.item()]) for ds in (half, whole))
    slope = np.array([new[1], -float(force(new[0]))])
    expected = middle / (g * (2 - g)) - old * (1 - g) ** 2 / (g * (2 - g)) + (1 - g) / (2 - g) * dt * slope
    np.testing.assert_allclose(new, expected, rtol=1e-11)


def test_bathe_is_the_euler_method_through_three_points():
    """u̇₁ = (u₀ − 4u_½ + 3u₁)/Δt, and ü₁ likewise from the velocities."""
    dt, force = 0.15 / 40, study.problems["hardening"].force
    half = study.run("hardening", "average_acceleration", dt=dt / 2, steps=1).isel(t=1)
    whole = study.run("hardening", "bathe", dt=dt, steps=1).isel(t=1)
    assert whole.v.item() == pytest.approx((1.5 - 4 * half.u.item() + 3 * whole.u.item()) / dt, rel=1e-10)
    assert -float(force(whole.u.item())) == pytest.approx((-4 * half.v.item() + 3 * whole.v.item()) / dt, rel=1e-10)


@pytest.mark.filterwarnings("ignore:.* has negative numerical damping:RuntimeWarning")
def test_parks_method_is_the_mean_of_bdf2_and_bdf3():
    bdf3 = (11 / 6, -3.0, 3 / 2, -1 / 3)
    mean = np.mean([(*bdf2.weights, 0.0), bdf3], axis=0)
    np.testing.assert_allclose(park.weights, mean, rtol=1e-15)
    assert study.BackwardDifferences(weights=bdf3).order == 3


def test_the_other_end_of_chung_and_lees_range_is_hulbert_and_chungs():
    lee, hulbert = chung_lee, study.ExplicitAlpha.hulbert_chung(rho_b=0.5)
    assert (lee.alpha_m, lee.beta, lee.gamma) == pytest.approx((hulbert.alpha_m, hulbert.beta, hulbert.gamma))


def test_fox_and_goodwin_is_numerov():
    """uₙ₊₁ − 2uₙ + uₙ₋₁ = −Δt²/12 (p(uₙ₊₁) + 10 p(uₙ) + p(uₙ₋₁))."""
    dt = 0.15 / 40
    u = _trajectory("fox_goodwin", dt=dt)
    p = np.asarray(study.problems["hardening"].force(u))
    residual = u[2:] - 2 * u[1:-1] + u[:-2] + dt**2 / 12 * (p[2:] + 10 * p[1:-1] + p[:-2])
    np.testing.assert_allclose(residual, 0, atol=1e-11)


#: Printed displacements after 12 steps of 0.28, from Bathe, Finite Element Procedures, examples 9.1 to 9.4.
BATHE_PRINTED = {
    "central_difference": (study.schemes["central_difference"], (1.02, 2.60)),
    "houbolt": (study.Houbolt(start_by="central_difference"), (1.72, 2.28)),
    "average_acceleration": (study.schemes["average_acceleration"], (1.40, 2.31)),
    "bathe": (study.schemes["bathe"], (1.28, 2.40)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BATHE_PRINTED)
def test_examples_of_bathes_textbook(name):
    """M = diag(2, 1), K = [[6, −2], [−2, 4]], F = (0, 10), from rest."""
    stiffness, constant = jnp.array([[6.0, -2.0], [-2.0, 4.0]]), jnp.array([0.0, 10.0])
    problem = study.Problem(
        lambda u: stiffness @ u, np.zeros(2), np.zeros(2), mass=np.array([2.0, 1.0]), load=lambda t: constant
    )
    scheme, printed = BATHE_PRINTED[name]
    end = study.run(problem, scheme, dt=0.28, steps=12).u.values[-1]
    np.testing.assert_allclose(end, printed, atol=0.005001)


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


def test_alpha_method_of_1996_weights_two_forces():
    """The step satisfies eq. (12) with (1 + α) p(u₁) − α p(u₀), and not with p at the weighted displacement."""
    scheme, dt = hht_alpha_1996, 0.15 / 20
    force = study.problems["hardening"].force
    ds = study.run("hardening", scheme, dt=dt, steps=1)
    u0, u1 = ds.u.values
    a0 = -force(u0)
    a1 = (u1 - u0 - dt**2 * (0.5 - scheme.beta) * a0) / (scheme.beta * dt**2)
    two_forces = (1 + scheme.alpha) * force(u1) - scheme.alpha * force(u0)
    one_force = force((1 + scheme.alpha) * u1 - scheme.alpha * u0)
    assert a1 == pytest.approx(-two_forces, rel=1e-10)
    assert abs(a1 + one_force) > 1e-3 * abs(a1)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(
    stiffness=st.floats(0.5, 200.0),
    cubic=st.floats(0.0, 5.0),
    u0=st.floats(-2.0, 2.0),
    part=st.floats(0.002, 0.02),
)
def test_energy_of_faithful_schemes_stays_near(stiffness, cubic, u0, part):
    """The relative energy error of average acceleration and central difference stays below (ωΔt)² for 2000 steps."""
    spring = CubicSpring(stiffness, cubic)
    problem = study.Problem(spring.force, u0=u0 if abs(u0) > 1e-3 else 1.0, potential=spring.potential)
    fastest = np.sqrt(stiffness * (1 + 3 * cubic * 4))
    dt = 2 * np.pi * part / fastest
    for scheme in ("average_acceleration", "central_difference"):
        ds = study.run(problem, scheme, dt=dt, steps=2000, observe=["max_energy_error"])
        assert ds.status == 0
        assert ds.max_energy_error < (fastest * dt) ** 2
