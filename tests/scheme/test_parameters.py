"""Parameters of schemes: values that are refused, and coefficients that stay small."""

import math

import numpy as np
import pytest

import study
from study.scheme.diagonally_implicit import _tableau


@pytest.mark.parametrize(
    "make, name",
    [
        (lambda x: study.Newmark(beta=x, gamma=0.5), "beta"),
        (lambda x: study.Newmark(beta=0.25, gamma=x), "gamma"),
        (lambda x: study.WilsonTheta(theta=x), "theta"),
        (lambda x: study.HHTAlpha1996(alpha=x, beta=0.3025, gamma=0.6), "alpha"),
        (lambda x: study.HHTAlpha1996(alpha=-0.1, beta=math.nan if x is None else x, gamma=0.6), "beta"),
        (lambda x: study.GeneralizedAlpha(alpha_m=0.0, alpha_f=x, beta=0.25, gamma=0.5), "alpha_f"),
        (lambda x: study.GeneralizedAlpha.chung_hulbert(rho_inf=x), "rho_inf"),
        (lambda x: study.GeneralizedAlpha.hht(rho_inf=x), "rho_inf"),
        (lambda x: study.GeneralizedAlpha.wbz(rho_inf=x), "rho_inf"),
        (lambda x: study.KolayRicles(rho_inf=x), "rho_inf"),
        (lambda x: study.TwoStep(rho_inf=x), "rho_inf"),
        (lambda x: study.Bathe(gamma=x), "gamma"),
        (lambda x: study.Bathe.with_one_stiffness(rho_inf=x), "rho_inf"),
        (lambda x: study.ExplicitAlpha.hulbert_chung(rho_b=x), "rho_b"),
        (lambda x: study.ExplicitAlpha.chung_lee(beta=x), "beta"),
        (lambda x: study.BetaBathe(beta1=0.39, beta2=x), "beta2"),
        (lambda x: study.SingleSolve.icl(rho_b=x), "rho_b"),
        (lambda x: study.SingleSolve(rho_s=x, rho_b=0.2), "rho_s"),
        (lambda x: study.NohBathe(p=x), "p"),
        (lambda x: study.WangAdamsTamma(c1=x), "c1"),
        (lambda x: study.TchamwaWielgosz(phi=x), "phi"),
    ],
)
@pytest.mark.parametrize("value", [-0.5, float("nan"), float("inf"), "a", None, [0.25], 1j, np.array([0.25, 0.3])])
def test_parameters_out_of_range_are_refused(make, name, value):
    with pytest.raises(ValueError, match=rf"{name}=.*{name} must be"):
        make(value)


@pytest.mark.parametrize(
    "make, sentence",
    [
        (lambda: study.BackwardDifferences(weights=(1.0, 1.0)), "weights must be weights of a derivative"),
        (lambda: study.BackwardDifferences(weights=(2.0, -2.0)), "weights must be weights of a derivative"),
        (lambda: study.BackwardDifferences(weights="ab"), "weights must be a tuple of finite numbers"),
        (lambda: study.BackwardDifferences(weights=(1.0, float("nan"))), "weights must be a tuple of finite numbers"),
        (
            lambda: study.Splitting(drifts=(0.0, 1.0), kicks=(float("nan"),), order_without_damping=1),
            "kicks must be a tuple of finite numbers",
        ),
        (lambda: study.Composition(weights=1.0, order_without_damping=2), "weights must be a tuple of finite numbers"),
        (
            lambda: study.Composition(weights=(1.0,), order_without_damping="x"),
            "order_without_damping must be a whole number of at least 1",
        ),
        (lambda: study.Extrapolation(sequence=(True, 2)), "sequence must be a tuple of finite numbers"),
        (lambda: study.Extrapolation(sequence=3), "sequence must be a tuple of finite numbers"),
        (
            lambda: study.Splitting(drifts=(0.0, 1.0), kicks=(0.5,), order_without_damping=1),
            "kicks must be numbers that add up to one",
        ),
        (
            lambda: study.Splitting(drifts=(1.0,), kicks=(1.0,), order_without_damping=1),
            "one drift more than kicks, not 1 for 1",
        ),
        (
            lambda: study.KickDriftKick(kicks=(1.0,), drifts=(1.0,), order_without_damping=2),
            "one kick more than drifts, not 1 for 1",
        ),
        (
            lambda: study.Composition(weights=(0.5, 0.2, 0.3), order_without_damping=2),
            "weights must be the same from both ends",
        ),
        (lambda: study.Composition(weights=(), order_without_damping=2), "weights must be a tuple of finite numbers"),
        (lambda: study.Extrapolation(sequence=(2, 1)), "sequence must be whole numbers that rise from at least 1"),
        (lambda: study.DiagonallyImplicit(sub_steps=3, rho_inf=1.1), "rho_inf must be a number between 0 and 1"),
        (lambda: study.DiagonallyImplicit(sub_steps=5, rho_inf=0.8), "sub_steps must be 3 or 4"),
        (lambda: study.AverageVectorField(points=0), "points must be a whole number of at least 1"),
    ],
)
def test_weights_that_make_no_scheme_are_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


@pytest.mark.parametrize("s", [3, 4])
def test_no_weight_of_esdirk_is_large(s):
    """All weights stay below 3 at every ρ∞; they would grow if two stages of a step came close to each other."""
    assert max(np.abs(_tableau(s, rho_inf)).max() for rho_inf in np.linspace(0, 1, 101).tolist()) < 3
