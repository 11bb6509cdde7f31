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
        (study.GeneralizedAlpha.chung_hulbert, "rho_inf"),
        (study.GeneralizedAlpha.hht, "rho_inf"),
        (study.GeneralizedAlpha.wbz, "rho_inf"),
        (study.KolayRicles, "rho_inf"),
        (study.TwoStep, "rho_inf"),
        (lambda x: study.Bathe(gamma=x), "gamma"),
        (study.Bathe.of_one_stiffness, "rho_inf"),
        (study.ExplicitAlpha.hulbert_chung, "rho_b"),
        (study.ExplicitAlpha.chung_lee, "beta"),
        (lambda x: study.BetaBathe(0.39, x), "beta2"),
        (study.SingleSolve.icl, "rho_b"),
        (lambda x: study.SingleSolve(rho_s=x, rho_b=0.2), "rho_s"),
        (study.NohBathe, "p"),
        (study.WangAdamsTamma, "c1"),
        (study.TchamwaWielgosz, "phi"),
    ],
)
@pytest.mark.parametrize("value", [-0.5, float("nan"), float("inf"), "a", None, [0.25], 1j, np.array([0.25, 0.3])])
def test_parameters_out_of_range_are_refused(make, name, value):
    with pytest.raises(ValueError, match=rf"{name}=.*{name} must be"):
        make(value)


@pytest.mark.parametrize(
    "make, sentence",
    [
        (lambda: study.BackwardDifferences((1.0, 1.0)), "weights must be weights of a derivative"),
        (lambda: study.BackwardDifferences((2.0, -2.0)), "weights must be weights of a derivative"),
        (lambda: study.BackwardDifferences("ab"), "weights must be a tuple of finite numbers"),
        (lambda: study.BackwardDifferences((1.0, float("nan"))), "weights must be a tuple of finite numbers"),
        (lambda: study.Splitting((0.0, 1.0), (float("nan"),), of_order=1), "kicks must be a tuple of finite numbers"),
        (lambda: study.Composition(1.0, of_order=2), "weights must be a tuple of finite numbers"),
        (lambda: study.Composition((1.0,), of_order="x"), "of_order must be a whole number of at least 1"),
        (lambda: study.Extrapolation((True, 2)), "sequence must be a tuple of finite numbers"),
        (lambda: study.Extrapolation(3), "sequence must be a tuple of finite numbers"),
        (lambda: study.Splitting((0.0, 1.0), (0.5,), of_order=1), "kicks must be numbers that add up to one"),
        (lambda: study.Splitting((1.0,), (1.0,), of_order=1), "one drift more than kicks, not 1 for 1"),
        (lambda: study.KickDriftKick((1.0,), (1.0,), of_order=2), "one kick more than drifts, not 1 for 1"),
        (lambda: study.Composition((0.5, 0.2, 0.3), of_order=2), "weights must be the same from both ends"),
        (lambda: study.Composition((), of_order=2), "weights must be a tuple of finite numbers"),
        (lambda: study.Extrapolation((2, 1)), "sequence must be whole numbers that rise from at least 1"),
        (lambda: study.DiagonallyImplicit(3, rho_inf=1.1), "rho_inf must be a number between 0 and 1"),
        (lambda: study.DiagonallyImplicit(5, rho_inf=0.8), "sub_steps must be 3 or 4"),
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
