"""Methods from mixed Padé expansions: the amplification that defines them, order, stability and dissipation."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from study.algebra.matrices import banded
from study.mechanics.loads import HarmonicLoad

STEPS = np.geomspace(1e-2, 1e4, 400) / (2 * np.pi)


def expansion(upper, lower):
    """Coefficients of numerator and denominator of the Padé expansion of the exponential, by rising powers."""
    numerator = [math.comb(upper, k) * math.factorial(upper + lower - k) for k in range(upper + 1)]
    denominator = [math.comb(lower, k) * math.factorial(upper + lower - k) * (-1) ** k for k in range(lower + 1)]
    scale = (-1) ** lower / denominator[-1]
    return np.pad(numerator, (0, lower - upper)) * scale, np.array(denominator) * scale


@pytest.mark.slow
@pytest.mark.parametrize("rho_inf", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("terms", [1, 2, 3, 4, 5, 6])
def test_the_amplification_is_the_mean_of_two_expansions(terms, rho_inf):
    theory = study.LinearTheory(study.MixedPade(terms=terms, rho_inf=rho_inf), STEPS)
    high, low = (np.array(expansion(upper, terms)) for upper in (terms, terms - 1))
    numerator, denominator = (rho_inf * high + (1 - rho_inf) * low)[:, ::-1]
    z = 2j * np.pi * STEPS
    r = np.polyval(numerator, z) / np.polyval(denominator, z)
    np.testing.assert_allclose(np.trace(theory.matrices, axis1=1, axis2=2), 2 * r.real, atol=1e-11)
    np.testing.assert_allclose(np.linalg.det(theory.matrices), np.abs(r) ** 2, atol=1e-11)
    assert theory.spectral_radius.max() < 1 + 1e-11
    assert theory.spectral_radius[-1] == pytest.approx(rho_inf, abs=1e-3)


@pytest.mark.parametrize("terms, steps", [(1, 128), (2, 32), (3, 8), (4, 4)])
@pytest.mark.parametrize("rho_inf", [0.4, 1.0])
def test_the_order_holds_with_damping_and_load(terms, steps, rho_inf):
    stiffness, damping = np.array([[2.0, -1.0], [-1.0, 1.5]]), np.array([[0.2, -0.05], [-0.05, 0.1]])
    push, start = np.array([1.0, 0.5]), [1.0, 0.2, 0.3, -0.5]
    problem = study.Problem(
        stiffness=stiffness,
        damping=damping,
        u0=start[:2],
        v0=start[2:],
        load=HarmonicLoad(push, frequency=1.3, phase=0.4),
    )

    def rates(t, y):
        return np.append(y[2:], push * np.cos(1.3 * t - 0.4) - damping @ y[2:] - stiffness @ y[:2])

    exact = solve_ivp(rates, (0.0, 4.0), start, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    scheme, errors = study.MixedPade(terms=terms, rho_inf=rho_inf), []
    for n in (steps, 2 * steps):
        ds = study.run(problem, scheme, dt=4 / n, steps=n, every=n)
        errors.append(np.abs(np.append(ds.u.values[-1], ds.v.values[-1]) - exact).max())
    assert np.log2(errors[0] / errors[1]) > scheme.order - 0.3


def test_a_bar_with_a_tridiagonal_stiffness_moves_like_one_with_a_full_one():
    n = 40
    full = n * (np.diag(np.full(n, 2.0)) - np.eye(n, k=1) - np.eye(n, k=-1))
    start = np.sin(np.pi * np.arange(1, n + 1) / (n + 1))
    ends = [
        study.run(
            study.Problem(stiffness=stiffness, mass=np.full(n, 1 / n), damping=0.3 / n, u0=start),
            study.MixedPade(terms=3, rho_inf=0.5),
            dt=0.1,
            steps=20,
        ).u.values[-1]
        for stiffness in (full, banded(full, 1))
    ]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


def test_a_problem_with_a_force_is_refused():
    with pytest.raises(ValueError, match="'Mixed Padé' needs a linear problem without a force"):
        study.run("hardening", study.MixedPade(terms=3, rho_inf=0.5), dt=0.1, steps=1)
    with pytest.raises(ValueError, match="terms must be a whole number from 1 to 6"):
        study.MixedPade(terms=7, rho_inf=0.5)
