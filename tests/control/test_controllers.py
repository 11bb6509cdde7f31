"""Controllers: their published factors, their effect on the energy, and prescribed steps."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.control.codes import HalfIncrement, Nastran, Proportional
from study.control.controllers import DeadBand
from study.control.named import controllers

HARDENING = study.Problem(lambda u: u + u**3, potential=lambda u: u**2 / 2 + u**4 / 4, u0=1.5)


def factors(controller, estimates, k=3):
    """Ratios of successive step sizes, and which steps were accepted, for estimates relative to the tolerance."""
    carried, dt, ratios, accepted = controller.start(None, None, 1.0), 1.0, [], []
    for r in estimates:
        decision = controller.decide(carried, jnp.asarray(r), k, jnp.asarray(dt), None, None, 0.0, 1.0)
        ratios.append(float(decision.dt) / dt)
        accepted.append(bool(decision.accepted))
        carried, dt = decision.carried, float(decision.dt)
    return ratios, accepted


def test_published_factors():
    ratios, accepted = factors(controllers["integral"], [0.5, 2.0, 1e-9])
    assert ratios == pytest.approx([0.9 * 2 ** (1 / 3), 0.9 * 0.5 ** (1 / 3), 5.0]) and accepted == [True, False, True]
    ratios, accepted = factors(controllers["pi"], [0.5, 0.8, 3.0])
    by_hand = [0.9 * 0.5 ** (-0.7 / 3), 0.9 * 0.8 ** (-0.7 / 3) * 0.5 ** (0.4 / 3), 0.9 * 3 ** (-1 / 3)]
    assert ratios == pytest.approx(by_hand) and accepted == [True, True, False]
    ratios, accepted = factors(controllers["h211b"], [0.5, 0.8])
    first = 1 + np.arctan(0.5 ** (-1 / 12) - 1)
    second = 1 + np.arctan((0.8 * 0.5) ** (-1 / 12) * first ** (-1 / 4) - 1)
    assert ratios == pytest.approx([first, second]) and accepted == [True, True]


def test_the_step_stays_within_the_dead_band():
    ratios, accepted = factors(DeadBand(low=0.1, high=1.1, patience=2), [0.5, 0.05, 0.2, 0.05, 0.064, 1.05, 8.0])
    assert ratios == pytest.approx([1, 1, 1, 1, 2.25, 1, 0.45])
    assert accepted == [True] * 6 + [False]


def test_the_step_grows_after_three_good_increments():
    ratios, accepted = factors(HalfIncrement(), [0.5, 0.5, 0.5, 0.9, 0.5, 1.7, 0.2], k=2)
    assert ratios == pytest.approx([1, 1, 1.25, 1, 1, 0.5, 1]) and accepted == [True] * 5 + [False, True]


def test_powers_of_two():
    assert factors(Nastran(), 1 / np.array([0.3, 0.5, 1.0, 3.0, 5.0]), k=1)[0] == pytest.approx([0.25, 0.5, 1, 2, 4])


def test_the_step_is_proportional_to_the_iterations():
    ratios, accepted = factors(Proportional(largest=1.5), [2.0, 0.5, 0.1], k=1)
    assert ratios == pytest.approx([0.5, 2.0, 1.5]) and all(accepted)


def test_reversible_control_has_no_drift_and_the_usual_one_has():
    def density(u, v):
        return jnp.sqrt(jax.grad(HARDENING.force)(u) + 3.0)

    wanted = {"observe": ["energy_error"], "duration": 300.0}
    reversible = study.run(
        HARDENING, "average_acceleration", controller=study.Reversible(density), tolerance=0.2, **wanted
    )
    usual = study.run(HARDENING, "average_acceleration", tolerance=1e-4, **wanted)
    error, drift = abs(reversible.energy_error.values), abs(usual.energy_error.values)
    tenth = len(error) // 10
    assert error[-tenth:].max() == pytest.approx(error[:tenth].max(), rel=0.01)
    assert drift[-len(drift) // 10 :].min() > 5 * drift[: len(drift) // 10].max()
    assert 0.5 < usual.steps / reversible.steps < 2


def test_average_acceleration_keeps_the_energy_of_a_linear_oscillator_for_any_steps():
    rng = np.random.default_rng(1996)
    oscillator = study.Problem(lambda u: 4 * u, potential=lambda u: 2 * u**2, u0=1.0)
    steps = study.Prescribed(rng.uniform(0.01, 1.0, 200))
    ds = study.run(oscillator, "average_acceleration", controller=steps, observe=["max_energy_error"])
    assert ds.max_energy_error < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("h, H, stable", [(1, 1.55, True), (1, 1.57, False), (1.5, 1.5, True), (1.9, 2.1, True)])
def test_central_difference_with_alternating_steps(h, H, stable):
    limits = H * (h + H) <= 4 or (h * (h + H) >= 4 and h * H <= 4)
    ds = study.run(
        study.Problem(lambda u: u, u0=1.0),
        "central_difference",
        controller=study.Prescribed([h, H]),
        duration=500.0,
        observe=["peak"],
        bound=np.inf,
    )
    assert stable == limits == bool(ds.peak < 100)


def test_a_dead_band_with_a_small_bound_repeats_a_step_with_a_smaller_size():
    decision = DeadBand(low=0.1, high=0.5).decide(
        jnp.zeros((), int), jnp.asarray(0.6), 3, 1.0, HARDENING, None, 0.0, 1.0
    )
    assert not decision.accepted and decision.dt == pytest.approx(0.9)


def test_a_controller_says_what_it_needs():
    with pytest.raises(ValueError, match="controller 'PI' needs a tolerance"):
        study.run(HARDENING, "average_acceleration", controller="pi", duration=1.0)
    with pytest.raises(ValueError, match="'Prescribed' takes no tolerance without an estimator; leave it out"):
        study.run(HARDENING, "average_acceleration", controller=study.Prescribed([0.1]), tolerance=1e-3)
    with pytest.raises(ValueError, match="step sizes greater than zero"):
        study.Prescribed([0.1, -0.1])
    with pytest.raises(ValueError, match=r"DeadBand\(low=2.0\)"):
        DeadBand(low=2.0)
