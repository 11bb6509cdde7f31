"""Oscillators of one unknown."""

import mpmath
import numpy as np
import pytest
from scipy import special
from scipy.integrate import solve_ivp

import study
from reference import sundials
from study.problem import oscillators
from study.problem.named import known


def test_period_of_the_pendulum_near_its_top():
    problem = oscillators.pendulum()
    speed = float(problem.v0)
    period = float(4 * mpmath.ellipk(mpmath.mpf(speed) ** 2 / 4))
    assert period == pytest.approx(33.7210, abs=5e-5)
    end = study.run(problem, "gauss4", dt=period / 2 / 4000, steps=4000, every=4000).isel(t=-1)
    assert end.u.item() == pytest.approx(0, abs=1e-5)
    assert end.v.item() == pytest.approx(-speed, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "damping, amplitude, printed, within",
    [
        (0.05, 7.5, oscillators.UEDA_EXPONENT, 0.03),
        # printed in 1979
        (0.1, 10.0, 0.102, 0.11),
        (0.1, 11.0, 0.114, 0.11),
        (0.1, 12.0, 0.149, 0.11),
        (0.1, 13.0, 0.182, 0.11),
    ],
)
def test_ueda_s_oscillator_has_the_printed_exponents(damping, amplitude, printed, within):
    problem, starts = oscillators.ueda(damping, amplitude), 2.5 + np.linspace(0, 1, 16)
    half, whole = (
        study.run(problem, "rk4", dt=2 * np.pi / 64, steps=n, u0=starts, observe=["lyapunov_exponent"])
        for n in (32_000, 64_000)
    )
    rate = 2 * whole.lyapunov_exponent - half.lyapunov_exponent
    assert rate.mean().item() == pytest.approx(printed, rel=within)


@pytest.mark.slow
def test_van_der_pol_has_the_printed_end():
    problem, target = study.problems["van_der_pol"], known["van_der_pol"]
    # CVODE's tolerance bounds the error of a single step; the error at the end is larger
    reference = sundials.trajectory(problem, np.array([target.time]), rtol=1e-12, method="BDF")
    assert reference.u[-1] == pytest.approx(target.u, rel=1e-9)
    assert reference.v[-1] == pytest.approx(-0.8928097010247975, rel=1e-9)
    errors = {}
    for scheme in ("gauss4", "bathe"):
        end = study.run(problem, scheme, dt=target.time / 2**22, steps=2**22, every=2**22).u.values[-1]
        errors[scheme] = abs(end / target.u - 1)
    assert errors["gauss4"] < 1e-3 < errors["bathe"] < 0.02


def test_the_shallow_arch_turns_where_its_energy_says():
    target = known["shallow_arch"]
    reference = solve_ivp(
        lambda t, y: [y[1], oscillators.ARCH_LOAD - y[0] * (2 - y[0] * (3 - y[0]))],
        (0, target.time), [0, 0], "DOP853", rtol=1e-13, atol=1e-15,
    )  # fmt: skip
    # five passages near the unstable equilibrium enlarge the error of each step
    np.testing.assert_allclose(reference.y[:, -1], [target.u, 0.0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("part, snaps", [(0.999, False), (1.001, True)])
def test_the_shallow_arch_snaps_through_at_eight_twentysevenths(part, snaps):
    arch = study.problems["shallow_arch"]
    load = part * 8 / 27
    problem = study.Problem(arch.force, 0.0, load=lambda t: np.full((), load))
    ds = study.run(problem, "rk4", dt=0.01, steps=5000)
    assert bool((ds.u > 2 / 3).any()) == snaps


def test_mathieu_s_oscillator_moves_on_the_boundary_of_stability_as_mathieu_s_function():
    q = 0.4
    boundary = special.mathieu_a(1, q)
    t = np.linspace(0, 2 * np.pi, 9)
    exact = special.mathieu_cem(1, q, np.degrees(t))[0] / special.mathieu_cem(1, q, 0.0)[0]
    ds = study.run(oscillators.mathieu(boundary, -q), "nystrom4", dt=2 * np.pi / 800, steps=800, every=100)
    np.testing.assert_allclose(ds.u, exact, atol=1e-8)
