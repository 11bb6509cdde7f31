"""Linear theory derived from the code, compared with closed forms, runs and published claims."""

import re
import runpy

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

import study
from study.analysis.linear_theory import LinearTheory
from study.scheme.rederived import Rederived

PARTS = np.logspace(-3, 3, 121)

#: Number of steps of the runs with which linear theory is compared.
STEPS = 2000


#: Schemes with parameters that no named scheme has. Formulas give their stability limits.
OTHERS = [
    study.Newmark(beta=0.1, gamma=0.6),
    study.WilsonTheta(theta=1.0),
    study.GeneralizedAlpha.chung_hulbert(rho_inf=0.0),
    study.ExplicitAlpha.hulbert_chung(rho_b=0.0),
    study.ExplicitAlpha.chung_lee(beta=1.0),
    study.NohBathe(p=0.5),
    study.NohBathe(p=0.7),
    study.NohBathe(p=0.85),
    study.TchamwaWielgosz(phi=1.5),
    study.BetaBathe(beta1=0.6, beta2=0.7),
    study.BetaBathe(beta1=0.3, beta2=0.6, gamma=0.3),
    study.SingleSolve(rho_s=0.0, rho_b=0.5),
    study.WangAdamsTamma(c1=0.3),
    study.WangAdamsTamma(c1=0.4),
    study.DiagonallyImplicit(sub_steps=3, rho_inf=0.0),
    study.DiagonallyImplicit(sub_steps=4, rho_inf=1.0),
]

#: Schemes that amplify small steps, each with a neighbour that does not. Formulas give the limit zero.
GROWING = [
    (study.Newmark, {"beta": 0.25, "gamma": 0.4}, {"gamma": 0.5}),
    (study.WilsonTheta, {"gamma": 0.45}, {"gamma": 0.5}),
    (study.WilsonTheta, {"theta": 1.4, "beta": 0.3}, {"beta": 0.28}),
    (study.HHTAlpha1996, {"alpha": -0.1, "gamma": 0.55}, {"gamma": 0.65}),
    (study.GeneralizedAlpha, {"alpha_m": 0.3, "alpha_f": 0.2, "beta": 0.2, "gamma": 0.4}, {"beta": 0.1}),
    (study.GeneralizedAlpha, {"alpha_m": 0.1, "alpha_f": 0.2, "beta": 0.3, "gamma": 0.5}, {"gamma": 0.6}),
    (study.ExplicitAlpha, {"alpha_m": 0.0, "beta": 1.2, "gamma": 1.4}, {"gamma": 1.6}),
    (study.ExplicitAlpha, {"alpha_m": 0.0, "beta": 0.9, "gamma": 1.5}, {"beta": 1.1}),
    (study.BetaBathe, {"beta1": 0.39, "beta2": 0.5}, {"beta2": 0.7}),
    (study.BackwardDifferences, {"weights": (11 / 6, -3.0, 3 / 2, -1 / 3)}, {"weights": (3 / 2, -2.0, 1 / 2)}),
]


#: Spectral radii at infinite frequency that the authors of the schemes claim.
AT_INFINITY = {
    "average_acceleration": 1.0,
    "newmark_dissipative": 0.9 / 1.1,
    "houbolt": 0.0,
    "hht_alpha_1996": 0.9 / 1.1,
    "hht_alpha": 0.9 / 1.1,
    "wbz_alpha": 0.8,
    "generalized_alpha": 0.8,
    "kr_alpha": 0.8,
    "mkr_alpha": 0.8,
    "chen_ricles": 1.0,
    "chang": 1.0,
    "bdf2": 0.0,
    "park": 0.0,
    "oalts": 0.8,
    "bathe": 0.0,
    "tr_bdf2": 0.0,
    "rho_bathe": 0.5,
    "beta_bathe": 0.0,
    "implicit_midpoint": 1.0,
    "energy_momentum": 1.0,
    "average_vector_field": 1.0,
    "gauss4": 1.0,
    "esdirk3": 0.8,
    "esdirk4": 0.8,
}


def _states_its_limit(scheme):
    limit = LinearTheory(scheme, PARTS).stability_limit()
    said = f"give '{scheme.title}' stability_limit = {limit:.8g}, the limit of linear theory"
    assert scheme.stability_limit == pytest.approx(limit, rel=1e-6), said


@pytest.mark.slow
def test_a_scheme_states_the_stability_limit_of_linear_theory(scheme):
    _states_its_limit(scheme)


@pytest.mark.parametrize("scheme", OTHERS, ids=lambda scheme: scheme.title)
def test_a_formula_of_a_stability_limit_holds_for_other_parameters(scheme):
    _states_its_limit(scheme)


def test_limits_that_no_formula_gives_are_not_stated():
    bdf5 = study.BackwardDifferences(weights=(137 / 60, -5.0, 5.0, -10 / 3, 5 / 4, -1 / 5))
    for scheme in (study.WilsonTheta(theta=1.2), bdf5):
        assert scheme.stability_limit is None


def test_the_limits_in_docstrings_are_those_of_named_schemes():
    """Each number after "ωΔt ≤" in the docstring of a class is the stability limit of a named scheme of the class."""
    limits: dict[type, list[float]] = {}
    for scheme in study.schemes.values():
        limits.setdefault(type(scheme), []).append(scheme.stability_limit)
    number = re.compile(
        r"(?:ωΔt ≤|\\omega\s*\\Delta t \\leq?)\s+([\d.]*?)(?:(?:√|\\sqrt[ {]?)(\d+)}?)?(?=[.,;)`]*\s|$)"
    )
    stated_limits = [(kind, *parts) for kind in limits for parts in number.findall(kind.__doc__) if any(parts)]
    assert len(stated_limits) >= 10
    for kind, factor, root in stated_limits:
        said = float(factor or 1) * float(root or 1) ** 0.5
        assert any(abs(limit - said) < 1e-3 for limit in limits[kind]), f"no named {kind.__name__} has the limit {said}"


@pytest.mark.parametrize("name", AT_INFINITY)
def test_radii_at_infinite_frequency(name):
    theory = LinearTheory(study.schemes[name], PARTS)
    # double roots lose half of their digits, and triple roots two thirds
    assert theory.infinite_frequency_radius() == pytest.approx(AT_INFINITY[name], abs=1e-3)


def test_the_dataset_of_central_difference_has_its_closed_forms():
    ds = LinearTheory("central_difference", PARTS).dataset()
    assert ds.stability_limit == pytest.approx(2) and ds.linear_order == pytest.approx(2, abs=0.01) and ds.memory == 3
    # λ = exp(±iω̄Δt) with sin(ω̄Δt/2) = ωΔt/2
    stable = ds.sel(step_size_over_period=slice(1 / np.pi))
    omega = 2 * np.pi * stable.step_size_over_period
    exact = omega / (2 * np.arcsin(omega / 2)) - 1
    np.testing.assert_allclose(stable.period_elongation, exact, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(stable.spectral_radius, 1, atol=1e-7)
    # u₁ = (1 − Ω²/2) u₀ + Ω u̇₀/ω and u̇₁/ω = (−Ω + Ω³/4) u₀ + (1 − Ω²/2) u̇₀/ω
    powers = [ds[f"growth_{name}"].item() for name in ("u_from_u", "v_from_u", "u_from_v", "v_from_v")]
    assert powers == pytest.approx([2, 3, 1, 2], abs=1e-3)
    assert all({"long_name", "units"} <= set(variable.attrs) for variable in ds.variables.values())


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
def test_order_is_that_of_the_principal_roots(scheme_name, damping_ratio):
    """The order of the principal roots is the claimed order of the scheme, unless ``expected`` states another order."""
    scheme = study.schemes[scheme_name]
    expected = {
        # symplectic Euler is conjugate to velocity Verlet, and KR-α and MKR-α to the generalized-α method: their steps
        # are of second order, and only their starts lower the claimed order
        ("symplectic_euler", 0.0): 2,
        ("symplectic_euler", 0.1): 2,
        ("kr_alpha", 0.0): 2,
        ("kr_alpha", 0.1): 2,
        ("mkr_alpha", 0.0): 2,
        ("mkr_alpha", 0.1): 2,
        # Chen and Ricles' method is conjugate to the trapezoidal rule
        ("chen_ricles", 0.0): 2,
        ("chen_ricles", 0.1): 2,
        # WAT2 is of third order with damping or with a nonlinear force
        ("wat2", 0.0): 4,
        # without damping, Fox and Goodwin's method is Numerov's formula
        ("fox_goodwin", 0.0): 4,
    }.get((scheme_name, damping_ratio), scheme.order_with_damping if damping_ratio else scheme.order)
    theory = LinearTheory(scheme, np.logspace(-3, 0, 301), damping_ratio)
    assert theory.order() == pytest.approx(expected, abs=0.12)


@pytest.mark.parametrize("kind, parameters, change", GROWING)
def test_parameters_that_make_every_step_grow_are_warned_about(kind, parameters, change):
    """The limits are computed from the amplification matrix, and the warning names the line that makes the scheme."""
    with pytest.warns(RuntimeWarning, match=rf"{kind.__name__}\(.* negative numerical damping") as caught:
        growing = kind(**parameters)
    assert caught[0].filename == __file__
    stable = kind(**parameters | change)
    assert growing.stability_limit == 0 == LinearTheory(growing, [0.1]).stability_limit()
    assert stable.stability_limit != 0 < LinearTheory(stable, [0.1]).stability_limit()


@pytest.mark.slow
@pytest.mark.parametrize("damping_ratio", [0.0, 0.1])
@pytest.mark.parametrize("name", ["hht_alpha", "wbz_alpha", "generalized_alpha"])
def test_an_alpha_method_must_carry_its_acceleration(name, damping_ratio):
    """An acceleration recomputed from the equation of motion lowers the order to one, in linear theory and in runs."""
    scheme, parts = study.schemes[name], np.logspace(-3, 0, 301)
    assert LinearTheory(scheme, parts, damping_ratio).order() == pytest.approx(2, abs=0.05)
    assert LinearTheory(Rederived(scheme=scheme), parts, damping_ratio).order() == pytest.approx(1, abs=0.05)
    damped = study.Problem(lambda u: u + u**3, u0=1.0, damping=2 * damping_ratio)
    fine = study.run(damped, "rk4", dt=1e-3, steps=2000).u.values[-1]
    for method, order in ((scheme, 2), (Rederived(scheme=scheme), 1)):
        errors = [
            abs(study.run(damped, method, dt=2 / n, steps=n, every=n).u.values[-1] - fine) for n in (400, 800, 1600)
        ]
        assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(order, abs=0.1)


def _unit_oscillator(v0=0.0, damping_ratio=0.0):
    damping = np.float64(2 * damping_ratio) if damping_ratio else None
    return study.Problem(_identity, 1.0, v0, potential=_half_square, damping=damping)


def _identity(u):
    return u


def _half_square(u):
    return u * u / 2


def _is_the_power_of_the_matrix(scheme, damping_ratio):
    dt = 0.3
    # the same number of steps as in other runs of this file, so that they share a compiled program
    ds = study.run(_unit_oscillator(0.5, damping_ratio), scheme, dt=dt, steps=STEPS)
    start, _ = scheme.start(_unit_oscillator(0.5, damping_ratio), jnp.asarray(1.0), jnp.asarray(0.5), dt)
    (matrix,) = LinearTheory(scheme, np.array([dt / (2 * np.pi)]), damping_ratio).matrices
    states = [np.asarray(ravel_pytree(start)[0])]
    for _ in range(20):
        states.append(matrix @ states[-1])
    np.testing.assert_allclose(ds.u[:21], np.stack(states)[:, 0], atol=1e-12)
    np.testing.assert_allclose(ds.v[:21], np.stack(states)[:, 1], atol=1e-12)


@pytest.mark.slow
def test_the_run_is_the_power_of_the_matrix(sampled_scheme):
    """On the linear oscillator n steps multiply the state by the n-th power of the amplification matrix."""
    _is_the_power_of_the_matrix(study.schemes[sampled_scheme], 0.0)


@pytest.mark.slow
def test_the_run_is_the_power_of_the_matrix_with_damping_too(state_kind):
    _is_the_power_of_the_matrix(study.schemes[state_kind], 0.1)


@pytest.mark.parametrize("part", [1 / 20, 1 / 50])
def test_principal_roots_predict_the_motion_of_a_run(sampled_scheme, part):
    """The principal roots of the amplification matrix predict decay and period of a run over many periods."""
    motion = LinearTheory(sampled_scheme, np.array([1e-3, 1e-2, part])).motion()
    u = study.run(_unit_oscillator(), sampled_scheme, dt=2 * np.pi * part, steps=STEPS).u.values
    # fitted to the second half of the run, where the other roots have decayed: u = Re(c λⁿ)
    n = np.arange(STEPS // 2, STEPS + 1)
    rate = 2 * np.pi * part / (1 + motion.period_elongation[-1])
    decay = -np.log1p(-motion.amplitude_decay[-1]) * rate / (2 * np.pi)
    basis = np.exp(-decay * (n - n[0]))[:, None] * np.stack([np.cos(rate * n), np.sin(rate * n)], axis=1)
    amplitude, *_ = np.linalg.lstsq(basis, u[n], rcond=None)
    np.testing.assert_allclose(basis @ amplitude, u[n], atol=1e-9 * max(np.abs(u[n]).max(), 1e-3))


def test_damping_of_the_oscillator_is_seen(scheme):
    """At a small Ω = ωΔt and the damping ratio ξ = 0.1 the spectral radius is exp(−ξΩ) up to the local error."""
    omega = 2 * np.pi * 1e-3
    radius = LinearTheory(scheme, np.array([1e-3]), 0.1).spectral_radius[0]
    assert radius == pytest.approx(np.exp(-0.1 * omega), abs=max(omega ** (scheme.order_with_damping + 1), 1e-9))


def test_wilson_overshoots_and_average_acceleration_does_not():
    """At Δt = 10 T Wilson's method overshoots more than a hundredfold, and average acceleration does not overshoot."""
    at_ten = int(np.argmin(np.abs(PARTS - 10)))
    wilson, average = (
        LinearTheory(study.schemes[name], PARTS).overshoot()[0, at_ten]
        for name in ("wilson_theta", "average_acceleration")
    )
    assert wilson > 100
    assert average == pytest.approx(0, abs=1e-10)
    unstable = LinearTheory(study.schemes["central_difference"], PARTS).overshoot()[:, at_ten]
    assert np.isnan(unstable).all()


def test_an_overshoot_that_comes_late_is_seen():
    """Symplectic Euler keeps u² ± Ω u u̇/ω + (u̇/ω)² = 1, so that u and u̇/ω both reach 1/√(1 − Ω²/4)."""
    part = 0.158  # Δt/T at which u and u̇/ω need more than 32 steps to reach their maxima
    overshoot = LinearTheory("symplectic_euler", np.array([part])).overshoot()
    np.testing.assert_allclose(overshoot[:, 0], 1 / np.sqrt(1 - (np.pi * part) ** 2) - 1, rtol=0.01)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"step_size_over_period": [0.2, 0.1]}, "step_size_over_period must be positive and ascending"),
        ({"step_size_over_period": [0.0, 0.1]}, "step_size_over_period must be positive and ascending"),
        ({"step_size_over_period": 0.1}, "of shape (points,), not 0.1"),
        ({"step_size_over_period": "a"}, "step_size_over_period must be positive and ascending"),
        (
            {"step_size_over_period": PARTS, "damping_ratio": "a"},
            "damping_ratio must be at least 0 and less than 1, not a",
        ),
        (
            {"step_size_over_period": PARTS, "damping_ratio": 1.0},
            "damping_ratio must be at least 0 and less than 1, not 1.0",
        ),
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


@pytest.mark.parametrize("name, at", [("kahan_li8", 3.118), ("extrapolation12", 3.1414)])
def test_narrow_windows_of_instability_are_found(name, at):
    """The motion grows in an interval of ωΔt narrower than the spacing of a coarse grid; at larger ωΔt it is stable."""
    theory = LinearTheory(name, np.array([at, 3.3]) / (2 * np.pi))
    assert theory.spectral_radius[0] > 1 + 1e-5 and theory.spectral_radius[1] < 1 + 1e-10
    assert theory.stability_limit() < at


def test_a_grid_too_coarse_for_an_order_gives_none():
    assert np.isnan(LinearTheory(study.schemes["rk4"], np.array([0.01, 0.1])).order())


def test_a_scheme_that_grows_weakly_is_stable_at_no_step():
    # Heun's method: |R|² = 1 + Ω⁴/4, which is within round-off of one at small steps
    scope = runpy.run_path("examples/scheme.py")
    assert study.LinearTheory(scope["heun"], np.logspace(-3, 0, 5)).stability_limit() == 0.0


@pytest.mark.parametrize(
    "name, from_u, from_v",
    [
        ("average_acceleration", [0, 0], [0, 0]),
        ("hht_alpha", [0, 1], [0, 0]),
        ("wilson_theta", [2, 1], [1, 0]),  # as published by Hilber and Hughes for collocation methods
        ("central_difference", [2, 3], [1, 2]),  # u₁ = (1 − Ω²/2) u₀ + Ω v₀
        ("chen_ricles", [0, 0], [1, 0]),
    ],
)
def test_powers_of_overshoot(name, from_u, from_v):
    np.testing.assert_allclose(LinearTheory(name, PARTS).growth(), [from_u, from_v], atol=0.01)
