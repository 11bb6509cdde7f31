"""Dormand and Prince's pair: the order conditions of both methods, and the order of their error estimate."""

import numpy as np
import pytest

import study
from study.scheme.embedded_nystrom import dormand_prince6

TABLEAU = dormand_prince6.tableau
C = np.array(TABLEAU.c)


@pytest.mark.parametrize(
    "b, b_velocity, order",
    [(TABLEAU.b, TABLEAU.b_velocity, 6), (TABLEAU.b_hat, TABLEAU.b_hat_velocity, 4)],
    ids=["order 6", "embedded, order 4"],
)
def test_conditions_of_order(b, b_velocity, order):
    """Both methods meet Σ b cᵏ = 1/((k + 1)(k + 2)) and Σ b′ cᵏ = 1/(k + 1) up to their order, and not beyond it."""
    displacement_defects = [np.dot(b, C[: len(b)] ** k) - 1 / ((k + 1) * (k + 2)) for k in range(order)]
    velocity_defects = [np.dot(b_velocity, C**k) - 1 / (k + 1) for k in range(order + 1)]
    np.testing.assert_allclose(displacement_defects[:-1], 0, atol=1e-14)
    np.testing.assert_allclose(velocity_defects[:-1], 0, atol=1e-14)
    assert abs(displacement_defects[-1]) > 1e-5 and abs(velocity_defects[-1]) > 1e-5


def test_the_embedded_method_estimates_the_error_with_its_order():
    """The difference of both methods after one step falls with the fifth power of the step, as a local error does."""

    def step(dt):
        k = [-1.5 - 1.5**3]
        for c, row in zip(TABLEAU.c[1:], TABLEAU.a[1:], strict=True):
            u = 1.5 + c * dt * 0.7 + dt**2 * sum(w * x for w, x in zip(row, k, strict=False))
            k.append(-u - u**3)
        return dt * np.dot(np.subtract(TABLEAU.b_velocity, TABLEAU.b_hat_velocity), k)

    differences = np.abs([step(dt) for dt in (0.02, 0.01, 0.005)])
    assert np.log2(differences[:-1] / differences[1:]) == pytest.approx(5, abs=0.15)


def test_an_undamped_motion_grows_slowly_at_every_step_size():
    omega = np.array([0.5, 1.0])
    growth = study.LinearTheory(dormand_prince6, omega / (2 * np.pi)).spectral_radius - 1
    assert growth == pytest.approx(4e-6 * omega**8, rel=0.3)
