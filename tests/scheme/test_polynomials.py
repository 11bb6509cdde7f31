"""Characteristic polynomials derived from the code, compared with closed forms."""

import math

import numpy as np
import pytest

import study
from study.analysis.linear_theory import LinearTheory

PARTS = np.logspace(-3, 3, 121)


STEPS = 2 * np.pi * PARTS


def _polynomials(scheme, parts=PARTS, damping_ratio=0.0):
    """Characteristic polynomials by step size; unlike double roots, coefficients do not lose half of their digits."""
    return np.array([np.poly(roots) for roots in LinearTheory(scheme, parts, damping_ratio).roots])


def _assert_roots(scheme, expected, parts=PARTS, tolerance=1e-10):
    """Check that the polynomial of each step size has the expected roots, to a tolerance relative to its terms."""
    for polynomial, roots in zip(_polynomials(scheme, parts), expected, strict=True):
        residual = np.abs(np.polyval(polynomial, roots))
        assert np.all(residual < tolerance * np.polyval(np.abs(polynomial), np.abs(roots)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["average_acceleration", "implicit_midpoint", "energy_momentum", "average_vector_field", "chen_ricles", "chang"],
)
def test_the_trapezoidal_rule_neither_damps_nor_grows(name):
    """The roots are λ = (1 ± iΩ/2)/(1 ∓ iΩ/2) with Ω = ωΔt."""
    expected = (1 + 0.5j * STEPS) / (1 - 0.5j * STEPS)
    theory = LinearTheory(study.schemes[name], PARTS)
    assert np.abs(theory.roots - expected[:, None]).min(axis=1).max() < 1e-10
    motion = theory.motion()
    np.testing.assert_allclose(motion.period_elongation, STEPS / (2 * np.arctan(STEPS / 2)) - 1, atol=1e-10)
    np.testing.assert_allclose(motion.algorithmic_damping, 0, atol=1e-10)


def test_central_difference_shortens_the_period():
    """The roots of central difference have the angle 2 arcsin(Ω/2), up to Ω = ωΔt = 2."""
    swinging = STEPS < 2
    motion = LinearTheory(study.schemes["central_difference"], PARTS).motion()
    expected = STEPS[swinging] / (2 * np.arcsin(STEPS[swinging] / 2)) - 1
    np.testing.assert_allclose(motion.period_elongation[swinging], expected, atol=1e-10)
    assert np.isnan(motion.period_elongation[~swinging]).all()


@pytest.mark.parametrize("name, last", [("rk4", 4), ("nystrom4", None)])
def test_explicit_runge_kutta_methods_are_series(name, last):
    """The root of rk4 is the series of e^z up to z⁴, z = iΩ; the matrix of nystrom4 has the trace 2 − Ω² + Ω⁴/12."""
    parts = PARTS[STEPS < 10]
    omega = 2 * np.pi * parts
    if last:
        z = 1j * omega
        _assert_roots(study.schemes[name], (1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)[:, None], parts)
    else:
        for polynomial, x in zip(_polynomials(study.schemes[name], parts), omega**2, strict=True):
            # u₁ and u̇₁ in terms of u₀ and u̇₀, from the three stages with F = −u
            matrix = np.array([[1 - x / 2 + x**2 / 24, 1 - x / 6], [-1 + x / 6 - x**2 / 96, 1 - x / 2 + x**2 / 24]])
            # for the state (u, Δt u̇), the coefficient of u₀ in Δt u̇₁ has the factor Ω²
            expected = np.poly(matrix * np.array([[1, 1], [x, 1]]))
            np.testing.assert_allclose(polynomial, expected, rtol=1e-10, atol=1e-10 * (1 + x**2))


def test_gauss_is_the_pade_approximation():
    """λ = (1 + z/2 + z²/12)/(1 − z/2 + z²/12), z = iΩ."""
    z = 1j * STEPS
    _assert_roots(study.schemes["gauss4"], ((1 + z / 2 + z**2 / 12) / (1 - z / 2 + z**2 / 12))[:, None])


@pytest.mark.slow
@pytest.mark.parametrize("s, rho_inf, gamma", [(3, 0.0, 0.4358665215), (3, 1.0, 1 / 3), (4, 0.0, 0.5728160625)])
def test_esdirk_is_the_restricted_pade_approximation(s, rho_inf, gamma):
    """λ = Σ zᵏ Σ C(s, j) (−γ)ʲ/(k − j)! / (1 − γz)ˢ, z = iΩ; for ρ∞ = 0, γ is that printed for L-stable methods."""
    z = 1j * STEPS
    numerator = sum(
        z**k * sum(math.comb(s, j) * (-gamma) ** j / math.factorial(k - j) for j in range(k + 1)) for k in range(s + 1)
    )
    roots = LinearTheory(study.DiagonallyImplicit(sub_steps=s, rho_inf=rho_inf), PARTS).roots
    assert np.abs(roots - (numerator / (1 - gamma * z) ** s)[:, None]).min(axis=1).max() < 1e-8


def test_houbolt_has_its_polynomial():
    """(2 + Ω²) λ³ − 5λ² + 4λ − 1 = 0 without damping."""
    for polynomial, omega in zip(_polynomials(study.schemes["houbolt"]), STEPS, strict=True):
        expected = np.array([2 + omega**2, -5, 4, -1]) / (2 + omega**2)
        np.testing.assert_allclose(polynomial[:4], expected, atol=1e-10)
        np.testing.assert_allclose(polynomial[4:], 0, atol=1e-10)


@pytest.mark.parametrize("name", ["bdf2", "park"])
def test_backward_differences_have_their_polynomials(name):
    """(Σ d_k λ⁻ᵏ)² + Ω² = 0."""
    scheme = study.schemes[name]
    assert isinstance(scheme, study.BackwardDifferences)
    square = np.polymul(scheme.weights, scheme.weights)
    for polynomial, omega in zip(_polynomials(scheme), STEPS, strict=True):
        expected = np.polyadd(square, [omega**2, *[0] * (len(square) - 1)])
        np.testing.assert_allclose(polynomial[: len(expected)], expected / expected[0], atol=1e-10)


def test_wilson_has_its_polynomial():
    """The polynomial is that of the matrix in Bathe's textbook for θ = 1.4, in (ü, u̇, u) with Δt = 1."""
    theta = 1.4
    for polynomial, omega in zip(_polynomials(study.schemes["wilson_theta"]), STEPS, strict=True):
        beta = 1 / (theta / omega**2 + theta**3 / 6)
        matrix = [
            [1 - beta * theta**2 / 3 - 1 / theta, -beta * theta, -beta],
            [1 - 1 / (2 * theta) - beta * theta**2 / 6, 1 - beta * theta / 2, -beta / 2],
            [1 / 2 - 1 / (6 * theta) - beta * theta**2 / 18, 1 - beta * theta / 6, 1 - beta / 6],
        ]
        np.testing.assert_allclose(polynomial, np.poly(matrix), atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("rho_inf", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_the_generalized_alpha_family_meets_its_spectral_radius(rho_inf):
    """At infinite frequency both principal roots are −ρ∞; with Chung and Hulbert's method and KR-α all three are."""
    infinity, minus = np.array([1e7]), -rho_inf
    schemes = study.GeneralizedAlpha.chung_hulbert(rho_inf=rho_inf), study.KolayRicles(rho_inf=rho_inf)
    (chung,), (kolay,) = (_polynomials(scheme, infinity) for scheme in schemes)
    np.testing.assert_allclose(chung, np.poly([minus] * 3), atol=1e-10)
    np.testing.assert_allclose(kolay, chung, atol=1e-8)
    if rho_inf >= 0.5:
        hht = _polynomials(study.GeneralizedAlpha.hht(rho_inf=rho_inf), infinity)[0]
        assert abs(np.polyval(hht, minus)) < 1e-10 and abs(np.polyval(np.polyder(hht), minus)) < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 0.8])
def test_zhangs_method_damps_low_frequencies_half_as_much_as_the_generalized_alpha_method(rho_inf):
    """The algorithmic damping ratio of both is proportional to Ω³; at equal ρ∞ their quotient tends to one half."""
    parts = np.array([1e-3, 2e-3, 5e-3, 1e-2])
    zhang, chung = (
        LinearTheory(scheme, parts).motion().algorithmic_damping
        for scheme in (study.TwoStep(rho_inf=rho_inf), study.GeneralizedAlpha.chung_hulbert(rho_inf=rho_inf))
    )
    assert zhang[-1] / chung[-1] == pytest.approx(0.5, abs=3e-3)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_kr_alpha_has_the_roots_of_the_generalized_alpha_method(damping_ratio):
    implicit = _polynomials(study.schemes["generalized_alpha"], damping_ratio=damping_ratio)
    explicit = _polynomials(study.schemes["kr_alpha"], damping_ratio=damping_ratio)
    np.testing.assert_allclose(explicit, implicit, atol=1e-10)


@pytest.mark.parametrize("rho_b", [0.0, 0.3, 0.5, 0.8])
def test_hulbert_and_chungs_roots_meet_where_they_say(rho_b):
    """At Ω = (1 + ρ_b)√(2 − ρ_b) the principal roots meet at −ρ_b; at the stability limit one of them is −1."""
    scheme = study.ExplicitAlpha.hulbert_chung(rho_b=rho_b)
    meeting = (1 + rho_b) * np.sqrt(2 - rho_b) / (2 * np.pi)
    polynomial = _polynomials(scheme, np.array([meeting]))[0]
    assert abs(np.polyval(polynomial, -rho_b)) < 1e-10
    assert abs(np.polyval(np.polyder(polynomial), -rho_b)) < 1e-10
    limit = np.sqrt(2 * (1 - 2 * scheme.alpha_m) / (2 * scheme.beta - scheme.gamma))
    assert LinearTheory(scheme, PARTS).stability_limit() == pytest.approx(limit, rel=1e-6)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
@pytest.mark.parametrize(
    "first, second",
    [
        (study.SingleSolve(rho_s=0.8, rho_b=0.8), study.ExplicitAlpha.hulbert_chung(rho_b=0.8)),
        (study.SingleSolve.icl(rho_b=0.5), study.ExplicitAlpha.chung_lee(beta=28 / 27)),
        (study.SingleSolve.icl(rho_b=1.0), study.ExplicitAlpha.chung_lee(beta=1.0)),
    ],
    ids=["ρ_s = ρ_b", "ICL, ρ_b = ½", "ICL, ρ_b = 1"],
)
def test_explicit_methods_with_one_force_share_their_polynomials(first, second, damping_ratio):
    """GSSE evaluates its force at another time than the other methods, but has the same sequence of displacements."""
    parts = PARTS[STEPS < 2]
    first_polynomials, second_polynomials = (_polynomials(scheme, parts, damping_ratio) for scheme in (first, second))
    np.testing.assert_allclose(first_polynomials, second_polynomials, atol=1e-10)


@pytest.mark.parametrize("rho_s, rho_b", [(0.0, 0.8), (0.125, 0.8), (0.5, 0.9)])
def test_the_roots_of_gsse_meet_at_its_parameters(rho_s, rho_b):
    """At one step size the principal roots meet at −ρ_b, and the third root is −ρ_s."""
    omega = np.linspace(1.5, 2, 4001)
    polynomials = _polynomials(study.SingleSolve(rho_s=rho_s, rho_b=rho_b), omega / (2 * np.pi))
    meeting = np.poly([-rho_b, -rho_b, -rho_s])
    assert np.abs(polynomials - meeting).max(axis=1).min() < 2e-3


@pytest.mark.slow
@pytest.mark.parametrize("theta, stable", [(1.36, False), (1.37, True), (1.4, True)])
def test_wilson_is_unconditionally_stable_from_1_366(theta, stable):
    assert (LinearTheory(study.WilsonTheta(theta=theta), PARTS).stability_limit() == np.inf) == stable


@pytest.mark.slow
@pytest.mark.parametrize("name", ["yoshida4", "yoshida6", "kahan_li8", "mclachlan4", "blanes_moan4"])
def test_splittings_are_stable_as_long_as_their_product_is(name):
    """At the stability limit, half the trace of the product of all kicks and drifts first leaves [−1, 1]."""
    scheme, omega = study.schemes[name], np.linspace(1e-3, 6, 60_000)
    if isinstance(scheme, study.Splitting):
        moves = [("drift", scheme.drifts[0])]
        for kick, drift in zip(scheme.kicks, scheme.drifts[1:], strict=True):
            moves += [("kick", kick), ("drift", drift)]
    elif isinstance(scheme, study.KickDriftKick):
        moves = [("kick", scheme.kicks[0])]
        for kick, drift in zip(scheme.kicks[1:], scheme.drifts, strict=True):
            moves += [("drift", drift), ("kick", kick)]
    else:
        assert isinstance(scheme, study.Composition)
        moves = [move for w in scheme.weights for move in (("kick", w / 2), ("drift", w), ("kick", w / 2))]
    product = np.broadcast_to(np.eye(2), (len(omega), 2, 2))
    for kind, weight in moves:
        factor = np.broadcast_to(np.eye(2), (len(omega), 2, 2)).copy()
        factor[:, 0, 1], factor[:, 1, 0] = (weight * omega, 0) if kind == "drift" else (0, -weight * omega)
        product = factor @ product
    first = omega[np.argmax(np.abs(np.trace(product, axis1=1, axis2=2)) / 2 > 1 + 1e-9)]
    assert LinearTheory(scheme, PARTS).stability_limit() == pytest.approx(first, abs=3e-4)
