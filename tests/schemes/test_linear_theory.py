"""Linear theory out of the code against closed forms, against the run itself, and against what is claimed."""

import re

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

import study
from study.analysis.linear_theory import LinearTheory
from study.scheme.rederived import Rederived

PARTS = np.logspace(-3, 3, 121)
STEPS = 2 * np.pi * PARTS

#: Stability limits without damping as printed or derived by others, infinite where there is none.
LIMITS = {
    "central_difference": 2.0,
    "linear_acceleration": 2 * np.sqrt(3),
    "fox_goodwin": np.sqrt(6),
    "rk4": 2 * np.sqrt(2),
    "symplectic_euler": 2.0,
    "tchamwa_wielgosz": 2 / np.sqrt(2 * 1.033 - 1),
    "chung_lee": np.sqrt(2 / (2 * 28 / 27 - 1.5)),
}
#: Spectral radii at infinite frequency as claimed by those who made the schemes.
AT_INFINITY = {
    "average_acceleration": 1.0,
    "newmark_dissipative": 0.9 / 1.1,
    "houbolt": 0.0,
    "hht_alpha": 0.9 / 1.1,
    "hht_alpha_one_force": 0.9 / 1.1,
    "wbz_alpha": 0.8,
    "generalized_alpha": 0.8,
    "kr_alpha": 0.8,
    "bdf2": 0.0,
    "park": 0.0,
    "bathe": 0.0,
    "tr_bdf2": 0.0,
    "rho_bathe": 0.5,
    "implicit_midpoint": 1.0,
    "energy_momentum": 1.0,
    "average_vector_field": 1.0,
    "gauss4": 1.0,
}


def _polynomials(scheme, parts=PARTS, damping_ratio=0.0):
    """Characteristic polynomials; unlike their roots they do not lose half of the digits where roots meet."""
    return np.array([np.poly(roots) for roots in LinearTheory(scheme, parts, damping_ratio).roots])


def _assert_roots(scheme, expected, parts=PARTS, tolerance=1e-10):
    """Each expected root of each step size is a root of the characteristic polynomial, in units of its coefficients."""
    for polynomial, roots in zip(_polynomials(scheme, parts), expected, strict=True):
        residual = np.abs(np.polyval(polynomial, roots))
        assert np.all(residual < tolerance * np.polyval(np.abs(polynomial), np.abs(roots)))


@pytest.mark.parametrize(
    "name", ["average_acceleration", "implicit_midpoint", "energy_momentum", "average_vector_field"]
)
def test_the_trapezoidal_rule_neither_damps_nor_grows(name):
    """λ = (1 ± iΩ/2)/(1 ∓ iΩ/2)."""
    expected = (1 + 0.5j * STEPS) / (1 - 0.5j * STEPS)
    theory = LinearTheory(study.schemes[name], PARTS)
    assert np.abs(theory.roots - expected[:, None]).min(axis=1).max() < 1e-10
    motion = theory.motion()
    np.testing.assert_allclose(motion.period_elongation, STEPS / (2 * np.arctan(STEPS / 2)) - 1, atol=1e-10)
    np.testing.assert_allclose(motion.algorithmic_damping, 0, atol=1e-10)


def test_central_difference_shortens_the_period():
    """Its roots have the angle 2 arcsin(Ω/2), up to Ω = 2."""
    swinging = STEPS < 2
    motion = LinearTheory(study.schemes["central_difference"], PARTS).motion()
    expected = STEPS[swinging] / (2 * np.arcsin(STEPS[swinging] / 2)) - 1
    np.testing.assert_allclose(motion.period_elongation[swinging], expected, atol=1e-10)
    assert np.isnan(motion.period_elongation[~swinging]).all()


@pytest.mark.parametrize("name, last", [("rk4", 4), ("nystrom4", None)])
def test_explicit_runge_kutta_methods_are_series(name, last):
    """The classical method is the exponential to z⁴, z = iΩ; Nyström's has trace 2 − Ω² + Ω⁴/12 and its determinant."""
    parts = PARTS[STEPS < 10]
    omega = 2 * np.pi * parts
    if last:
        z = 1j * omega
        _assert_roots(study.schemes[name], (1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)[:, None], parts)
    else:
        for polynomial, x in zip(_polynomials(study.schemes[name], parts), omega**2, strict=True):
            # u₁ and u̇₁ of the three stages, written out for F = −u
            matrix = np.array([[1 - x / 2 + x**2 / 24, 1 - x / 6], [-1 + x / 6 - x**2 / 96, 1 - x / 2 + x**2 / 24]])
            # in units of Δt the velocity's row is times Ω², the displacement's column over it
            expected = np.poly(matrix * np.array([[1, 1], [x, 1]]))
            np.testing.assert_allclose(polynomial, expected, rtol=1e-10, atol=1e-10 * (1 + x**2))


def test_gauss_is_the_pade_approximation():
    """λ = (1 + z/2 + z²/12)/(1 − z/2 + z²/12), z = iΩ."""
    z = 1j * STEPS
    _assert_roots(study.schemes["gauss4"], ((1 + z / 2 + z**2 / 12) / (1 - z / 2 + z**2 / 12))[:, None])


def test_houbolt_has_its_polynomial():
    """(2 + Ω²) λ³ − 5λ² + 4λ − 1 = 0 without damping."""
    for polynomial, omega in zip(_polynomials(study.schemes["houbolt"]), STEPS, strict=True):
        expected = np.array([2 + omega**2, -5, 4, -1]) / (2 + omega**2)
        np.testing.assert_allclose(polynomial[:4], expected, atol=1e-10)
        np.testing.assert_allclose(polynomial[4:], 0, atol=1e-10)


@pytest.mark.parametrize("name", ["bdf2", "park"])
def test_backward_differences_have_their_polynomials(name):
    """(Σ d_k λ⁻ᵏ)² + Ω² = 0."""
    weights = study.schemes[name].weights
    square = np.polymul(weights, weights)
    for polynomial, omega in zip(_polynomials(study.schemes[name]), STEPS, strict=True):
        expected = np.polyadd(square, [omega**2, *[0] * (len(square) - 1)])
        np.testing.assert_allclose(polynomial[: len(expected)], expected / expected[0], atol=1e-10)


def test_wilson_has_its_polynomial():
    """The matrix of Bathe's textbook for θ = 1.4, in (ü, u̇, u) with Δt = 1."""
    theta = 1.4
    for polynomial, omega in zip(_polynomials(study.schemes["wilson_theta"]), STEPS, strict=True):
        beta = 1 / (theta / omega**2 + theta**3 / 6)
        matrix = [
            [1 - beta * theta**2 / 3 - 1 / theta, -beta * theta, -beta],
            [1 - 1 / (2 * theta) - beta * theta**2 / 6, 1 - beta * theta / 2, -beta / 2],
            [1 / 2 - 1 / (6 * theta) - beta * theta**2 / 18, 1 - beta * theta / 6, 1 - beta / 6],
        ]
        np.testing.assert_allclose(polynomial, np.poly(matrix), atol=1e-10)


@pytest.mark.parametrize("rho_inf", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_the_generalized_alpha_family_meets_its_spectral_radius(rho_inf):
    """At infinite frequency both main roots are −ρ∞, and the third of the generalized-α method is as well."""
    infinity, minus = np.array([1e7]), -rho_inf
    (chung,), (kolay,) = (
        _polynomials(make(rho_inf), infinity) for make in (study.GeneralizedAlpha.chung_hulbert, study.KolayRicles)
    )
    np.testing.assert_allclose(chung, np.poly([minus] * 3), atol=1e-10)
    np.testing.assert_allclose(kolay, chung, atol=1e-8)
    if rho_inf >= 0.5:
        hht = _polynomials(study.GeneralizedAlpha.hht(rho_inf), infinity)[0]
        assert abs(np.polyval(hht, minus)) < 1e-10 and abs(np.polyval(np.polyder(hht), minus)) < 1e-10


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_kr_alpha_has_the_roots_of_the_generalized_alpha_method(damping_ratio):
    implicit = _polynomials(study.schemes["generalized_alpha"], damping_ratio=damping_ratio)
    explicit = _polynomials(study.schemes["kr_alpha"], damping_ratio=damping_ratio)
    np.testing.assert_allclose(explicit, implicit, atol=1e-10)


@pytest.mark.parametrize("rho_b", [0.0, 0.3, 0.5, 0.8])
def test_hulbert_and_chungs_roots_meet_where_they_say(rho_b):
    """At Ω = (1 + ρ_b)√(2 − ρ_b) the main roots meet at −ρ_b, and stability ends where one of them is −1."""
    scheme = study.ExplicitAlpha.hulbert_chung(rho_b)
    meeting = (1 + rho_b) * np.sqrt(2 - rho_b) / (2 * np.pi)
    polynomial = _polynomials(scheme, np.array([meeting]))[0]
    assert abs(np.polyval(polynomial, -rho_b)) < 1e-10
    assert abs(np.polyval(np.polyder(polynomial), -rho_b)) < 1e-10
    limit = np.sqrt(2 * (1 - 2 * scheme.alpha_m) / (2 * scheme.beta - scheme.gamma))
    assert LinearTheory(scheme, PARTS).stability_limit() == pytest.approx(limit, rel=1e-6)


@pytest.mark.parametrize("theta, stable", [(1.36, False), (1.37, True), (1.4, True)])
def test_wilson_is_unconditionally_stable_from_1_366(theta, stable):
    assert (LinearTheory(study.WilsonTheta(theta=theta), PARTS).stability_limit() == np.inf) == stable


@pytest.mark.parametrize("name", LIMITS)
def test_stability_limits(name):
    assert LinearTheory(study.schemes[name], PARTS).stability_limit() == pytest.approx(LIMITS[name], abs=1e-6)


@pytest.mark.parametrize("name", AT_INFINITY)
def test_radii_at_infinite_frequency(name):
    theory = LinearTheory(study.schemes[name], PARTS)
    # where two or three roots meet they approach it slowly, and half or two thirds of the digits are lost
    assert theory.infinite_frequency_radius() == pytest.approx(AT_INFINITY[name], abs=1e-3)
    assert theory.stability_limit() == np.inf


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_order_is_that_of_the_principal_roots(scheme_name, damping_ratio):
    """What a scheme claims is the order of its roots, but for those whose errors in phase and start do not add up."""
    scheme = study.schemes[scheme_name]
    expected = {
        # conjugate to velocity Verlet, and to the generalized-α method: the map is as good, the start is not
        ("symplectic_euler", 0.0): 2,
        ("symplectic_euler", 0.1): 2,
        ("kr_alpha", 0.0): 2,
        ("kr_alpha", 0.1): 2,
        # Numerov's formula
        ("fox_goodwin", 0.0): 4,
    }.get((scheme_name, damping_ratio), scheme.damped_order if damping_ratio else scheme.order)
    theory = LinearTheory(scheme, np.logspace(-3, 0, 301), damping_ratio)
    assert theory.order() == pytest.approx(expected, abs=0.12)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
@pytest.mark.parametrize("name", ["hht_alpha_one_force", "wbz_alpha", "generalized_alpha"])
def test_an_alpha_method_must_carry_its_acceleration(name, damping_ratio):
    """Re-derived from the equation of motion it drops to first order, in linear theory and in a run."""
    scheme, parts = study.schemes[name], np.logspace(-3, 0, 301)
    assert LinearTheory(scheme, parts, damping_ratio).order() == pytest.approx(2, abs=0.05)
    assert LinearTheory(Rederived(scheme), parts, damping_ratio).order() == pytest.approx(1, abs=0.05)
    damped = study.Problem(lambda u: u + u**3, u0=1.0, damping=2 * damping_ratio)
    fine = study.run(damped, "rk4", dt=1e-3, steps=2000).u.values[-1]
    for method, order in ((scheme, 2), (Rederived(scheme), 1)):
        errors = [
            abs(study.run(damped, method, dt=2 / n, steps=n, every=n).u.values[-1] - fine) for n in (400, 800, 1600)
        ]
        assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_the_run_is_the_power_of_the_matrix(scheme, damping_ratio):
    """On the linear oscillator n steps are the n-th power of the amplification matrix."""
    dt = 0.3
    problem = study.Problem(
        lambda u: u,
        u0=1.0,
        v0=0.5,
        potential=lambda u: u * u / 2,
        damping=2 * damping_ratio if damping_ratio else None,
    )
    ds = study.run(problem, scheme, dt=dt, steps=20)
    start, _ = scheme.start(problem, jnp.asarray(1.0), jnp.asarray(0.5), dt)
    (matrix,) = LinearTheory(scheme, np.array([dt / (2 * np.pi)]), damping_ratio).matrices
    states = [np.asarray(ravel_pytree(start)[0])]
    for _ in range(20):
        states.append(matrix @ states[-1])
    np.testing.assert_allclose(ds.u, np.stack(states)[:, 0], atol=1e-12)
    np.testing.assert_allclose(ds.v, np.stack(states)[:, 1], atol=1e-12)


@pytest.mark.parametrize("part", [1 / 20, 1 / 50])
def test_principal_roots_tell_the_motion_of_a_run(scheme, part):
    """Amplitude decay and elongation of the matrix are those that a run shows over many periods."""
    steps, theory = 2000, LinearTheory(scheme, np.array([1e-3, 1e-2, part]))
    motion = theory.motion()
    oscillator = study.Problem(lambda u: u, u0=1.0, potential=lambda u: u * u / 2)
    u = study.run(oscillator, scheme, dt=2 * np.pi * part, steps=steps).u.values
    # fitted to the later half, where what is not a principal root has died away: u = Re(c λⁿ)
    n = np.arange(steps // 2, steps + 1)
    rate = 2 * np.pi * part / (1 + motion.period_elongation[-1])
    decay = -np.log1p(-motion.amplitude_decay[-1]) * rate / (2 * np.pi)
    basis = np.exp(-decay * (n - n[0]))[:, None] * np.stack([np.cos(rate * n), np.sin(rate * n)], axis=1)
    amplitude, *_ = np.linalg.lstsq(basis, u[n], rcond=None)
    np.testing.assert_allclose(basis @ amplitude, u[n], atol=1e-9 * max(np.abs(u[n]).max(), 1e-3))


def test_damping_of_the_oscillator_is_seen(scheme):
    """With 10 % damping the spectral radius at small steps is exp(−ξΩ)."""
    radius = LinearTheory(scheme, np.array([1e-3]), 0.1).spectral_radius[0]
    assert radius == pytest.approx(np.exp(-0.1 * 2 * np.pi * 1e-3), abs=5e-6)


def test_wilson_overshoots_and_the_generalized_alpha_method_does_not():
    """At Δt = 10 T Wilson's displacement grows to hundreds of times the initial one."""
    at_ten = int(np.argmin(np.abs(PARTS - 10)))
    wilson, average = (
        LinearTheory(study.schemes[name], PARTS).overshoot()[0, at_ten]
        for name in ("wilson_theta", "average_acceleration")
    )
    assert wilson > 100
    assert average == pytest.approx(0, abs=1e-10)
    unstable = LinearTheory(study.schemes["central_difference"], PARTS).overshoot()[:, at_ten]
    assert np.isnan(unstable).all()


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"dt_over_period": [0.2, 0.1]}, "dt_over_period must be positive and ascending"),
        ({"dt_over_period": [0.0, 0.1]}, "dt_over_period must be positive and ascending"),
        ({"dt_over_period": 0.1}, "of shape (points,), not 0.1"),
        ({"dt_over_period": "a"}, "dt_over_period must be positive and ascending"),
        ({"dt_over_period": PARTS, "damping_ratio": "a"}, "damping_ratio must be at least 0 and less than 1, not a"),
        ({"dt_over_period": PARTS, "damping_ratio": 1.0}, "damping_ratio must be at least 0 and less than 1, not 1.0"),
    ],
)
def test_mistakes_get_a_sentence(arguments, sentence):
    with pytest.raises(ValueError, match=re.escape(sentence)):
        LinearTheory(study.schemes["rk4"], **arguments)


def test_a_scheme_can_be_named():
    assert LinearTheory("rk4", PARTS).stability_limit() == pytest.approx(2 * np.sqrt(2), abs=1e-7)
    with pytest.raises(KeyError, match="there is no scheme 'rk5'; did you mean 'rk4'"):
        LinearTheory("rk5", PARTS)


@pytest.mark.parametrize("parts", [np.array([0.1]), np.array([0.1, 0.5]), PARTS])
def test_a_stability_limit_does_not_depend_on_the_grid(parts):
    assert LinearTheory("central_difference", parts).stability_limit() == pytest.approx(2, abs=1e-7)


@pytest.mark.parametrize("name", ["yoshida4", "yoshida6", "kahan_li8", "mclachlan4"])
def test_splittings_are_stable_as_long_as_their_product_is(name):
    """Half the trace of the product of its kicks and drifts, written out, first leaves [−1, 1] at the limit."""
    scheme, omega = study.schemes[name], np.linspace(1e-3, 6, 60_000)
    if name == "mclachlan4":
        moves = [("drift", scheme.drifts[0])]
        for kick, drift in zip(scheme.kicks, scheme.drifts[1:], strict=True):
            moves += [("kick", kick), ("drift", drift)]
    else:
        moves = [move for w in scheme.weights for move in (("kick", w / 2), ("drift", w), ("kick", w / 2))]
    product = np.broadcast_to(np.eye(2), (len(omega), 2, 2))
    for kind, weight in moves:
        factor = np.broadcast_to(np.eye(2), (len(omega), 2, 2)).copy()
        factor[:, 0, 1], factor[:, 1, 0] = (weight * omega, 0) if kind == "drift" else (0, -weight * omega)
        product = factor @ product
    first = omega[np.argmax(np.abs(np.trace(product, axis1=1, axis2=2)) / 2 > 1 + 1e-9)]
    assert LinearTheory(scheme, PARTS).stability_limit() == pytest.approx(first, abs=3e-4)


@pytest.mark.parametrize("name, at", [("kahan_li8", 3.118), ("extrapolation12", 3.1414)])
def test_narrow_windows_of_instability_are_found(name, at):
    """Below π, between two points of a coarse grid, the motion grows; further on it is stable again."""
    theory = LinearTheory(name, np.array([at, 3.3]) / (2 * np.pi))
    assert theory.spectral_radius[0] > 1 + 1e-5 and theory.spectral_radius[1] < 1 + 1e-10
    assert theory.stability_limit() < at


def test_a_grid_too_coarse_for_an_order_gives_none():
    assert np.isnan(LinearTheory(study.schemes["rk4"], np.array([0.01, 0.1])).order())
