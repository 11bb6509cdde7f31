"""The step over another number of periods: exponents of schemes, and runs that an extrapolated step does keep."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.special import ellipk

import study
from study.analysis.duration import round_down, step_exponent, step_over


def _exponent(name, *quantity):
    scheme = study.schemes[name]
    return step_exponent(scheme.order, scheme.order_of_loss, *quantity)


@pytest.mark.slow
def test_schemes_that_state_it_keep_the_energy(sampled_scheme):
    """The spectral radius at ωΔt = 1 is one exactly for the schemes that state that they keep the energy."""
    radius = study.LinearTheory(sampled_scheme, np.array([1 / (2 * np.pi)])).spectral_radius.item()
    assert (abs(radius - 1) < 1e-13) == study.schemes[sampled_scheme].keeps_energy


def test_a_linear_oscillator_loses_no_more_energy_than_the_order_of_loss_states(sampled_scheme):
    """The spectral radius falls below one with the next higher power of Δt, since a step is one of 1/Δt in a second."""
    radius = study.LinearTheory(sampled_scheme, np.array([0.05, 0.1]) / np.pi).spectral_radius
    loss = np.abs(1 - radius)
    if (loss > 1e-12).all():
        assert np.log2(loss[1] / loss[0]) - 1 > study.schemes[sampled_scheme].order_of_loss - 0.2


@pytest.mark.parametrize(
    "name, motion, energy",
    [
        ("central_difference", 1 / 2, 0),
        ("yoshida4", 1 / 4, 0),
        ("bathe", 2 / 3, 1 / 3),
        ("rk4", 2 / 5, 1 / 5),
        ("newmark_dissipative", 2, 1),
        ("wat2", 2 / 3, 1 / 3),
        ("kr_alpha", 1, 1 / 3),
        ("chen_ricles", 1, 0),
    ],
)
def test_exponents_follow_from_the_order_and_the_loss(name, motion, energy):
    assert _exponent(name) == pytest.approx(motion) and _exponent(name, "energy") == pytest.approx(energy)


def test_a_linear_oscillator_keeps_the_delay():
    """Average acceleration lengthens the period by (ωΔt)²/12, so n periods are late by n (ωΔt)²/12 periods."""
    first = np.sqrt(12 * 1e-4 / 100)
    step = step_over(first, _exponent("average_acceleration"), 100, 1000)
    assert 1000 * step**2 / 12 == pytest.approx(1e-4)
    theory = study.LinearTheory("average_acceleration", np.array([step / (2 * np.pi)]))
    assert 1000 * theory.motion().period_elongation.item() == pytest.approx(1e-4, rel=1e-4)
    assert step_over(first, 0.5, 100, 50) == first


@pytest.mark.slow
@pytest.mark.parametrize("scheme, coarse", [("central_difference", 480), ("bathe", 550), ("rk4", 90)])
def test_a_step_of_400_periods_gives_the_step_of_1000(scheme, coarse):
    """The spring ü + u + u³ = 0 from rest at 1 moves as cn(√2 t) with m = ¼, here by its Fourier series."""
    k, complement = ellipk(0.25), ellipk(0.75)
    nome, period = np.exp(-np.pi * complement / k), 4 * k / np.sqrt(2)
    odd = np.arange(1.0, 20.0, 2.0)
    weights = 2 * np.pi / (k * np.sqrt(0.25)) * nome ** (odd / 2) / (1 + nome**odd)
    off = study.Quantity(
        lambda t, u: u - jnp.sum(weights * jnp.cos(odd * (2 * np.pi / period * t))), name="off", reduce="peak"
    )
    spring = study.Problem(potential=lambda u: u**2 / 2 + u**4 / 4, u0=1.0)

    def error(periods, count):
        run = study.run(spring, scheme, dt=period / count, steps=int(periods * count), observe=[off])
        return run.off.item()

    # the coarsest of these steps that keeps an error of 1 %, as all finer ones do
    counts = np.round(coarse * 1.08 ** np.arange(6))
    known = counts[1 + np.flatnonzero([error(400, count) > 0.01 for count in counts])[-1]]
    count = period / step_over(period / known, _exponent(scheme), 400, 1000)
    assert error(1000, known) > 0.01 >= error(1000, count) > 0.004


def test_a_step_is_rounded_down_to_two_digits():
    assert round_down(0.0139) == 0.013 and round_down(0.014) == 0.014
