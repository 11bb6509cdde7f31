"""Lyapunov exponents of numerical maps."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.analysis.linear_theory import LinearTheory, oscillator
from study.marching.run import sweep


def test_a_stretched_linear_map_grows_by_its_spectral_radius():
    dt = 1.1 * 2  # ωΔt, beyond the stability limit of central difference
    rho = LinearTheory("central_difference", np.array([dt / (2 * np.pi)])).spectral_radius[0]
    ds = sweep(oscillator(), "central_difference", dt=dt, steps=400, observe="lyapunov_exponent", bound=np.inf)
    assert ds.lyapunov_exponent.item() * dt == pytest.approx(np.log(rho), rel=0.01)
    # `apart_from` is the time at which a perturbation has grown by 2³³, after about ln 2³³ / ln ρ steps
    assert ds.apart_from.item() / dt == pytest.approx(np.log(2.0**33) / np.log(rho), abs=3)


def test_a_regular_map_has_no_exponent_and_neighbours_stay():
    ds = study.run("hardening", "average_acceleration", dt=0.0075, steps=20_000, observe=["lyapunov_exponent"])
    assert abs(ds.lyapunov_exponent.item() * 0.15) < 0.02 and np.isinf(ds.apart_from)


def test_neighbours_part_as_two_runs_do():
    u0, dt, steps = 0.5, 2.5, 400
    ds = study.run("double_well", "average_acceleration", dt=dt, steps=steps, observe=["lyapunov_exponent"])
    pair = study.run("double_well", "average_acceleration", dt=dt, steps=steps, u0=np.array([u0, u0 + 1e-10])).u
    met = int(np.argmax(np.abs(pair[1] - pair[0]).values > 1e-2))
    alone = study.run("double_well", "average_acceleration", dt=dt, steps=met, observe=["lyapunov_exponent"])
    assert ds.lyapunov_exponent.item() * dt > 0.1
    # exponent × time is the logarithm of the growth, which two runs show while their distance is small
    assert alone.lyapunov_exponent.item() * met * dt == pytest.approx(np.log(1e-2 / 1e-10), abs=2.5)


@pytest.mark.parametrize("n", [1, 4])
def test_equal_unknowns_have_the_exponent_of_one(n):
    problem = study.Problem(lambda u: -2 * u, np.ones(n), np.zeros(n))
    ds = study.run(problem, "rk4", dt=0.01, steps=2000, observe="lyapunov_exponent", bound=np.inf)
    # the rate √2, plus ln(√3/2)/(20 s): a displacement perturbation of length one has a growing part of length √3/2
    assert ds.lyapunov_exponent.item() == pytest.approx(np.sqrt(2) + np.log(np.sqrt(3) / 2) / 20, rel=1e-4)


def test_a_free_structure_is_not_only_shifted():
    problem = study.Problem(lambda u: jnp.stack([u[1] - u[0], u[0] - u[1]]), [0.0, 0.1], [0.0, 0.0])
    ds = study.run(problem, "rk4", dt=0.01, steps=2000, observe="lyapunov_exponent", bound=np.inf)
    assert ds.lyapunov_exponent.item() == pytest.approx(np.sqrt(2), rel=0.05)
