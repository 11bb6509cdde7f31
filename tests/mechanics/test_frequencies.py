"""Circular frequencies of small motions."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.mechanics.frequencies import frequencies


def test_a_charge_in_a_magnetic_field_has_its_cyclotron_frequency():
    charge = study.Problem(lambda u, v: 10.0 * jnp.stack([-v[1], v[0], 0 * v[2]]), np.zeros(3), [1.0, 0.0, 0.0])
    assert frequencies(charge) == pytest.approx([0.0, 0.0, 10.0], abs=1e-6)


@pytest.mark.parametrize("given_by", ["matrices", "force", "force at a time"])
def test_whirl_of_a_rotor(given_by):
    # ü + G u̇ + k u = 0 with G = g [[0, −1], [1, 0]] has the frequencies √(k + g²/4) ± g/2
    gyroscopic, k = 3.0 * np.array([[0.0, -1.0], [1.0, 0.0]]), 4.0
    rotor = {
        "matrices": lambda: study.Problem(stiffness=k, damping=gyroscopic, u0=[1.0, 0.0]),
        "force": lambda: study.Problem(lambda u, v: k * u + gyroscopic @ v, [1.0, 0.0]),
        "force at a time": lambda: study.Problem(lambda u, v, t: (k + t) * u + gyroscopic @ v, [1.0, 0.0]),
    }[given_by]()
    assert frequencies(rotor) == pytest.approx([1.0, 4.0])


def test_symmetric_damping_leaves_the_undamped_frequencies():
    stiffness = np.array([[3.0, -1.0], [-1.0, 2.0]])
    undamped = np.sqrt(np.linalg.eigvalsh(stiffness))
    for damping in (0.1 * stiffness, 50.0, np.array([[9.0, 1.0], [1.0, 0.0]])):
        assert frequencies(study.Problem(stiffness=stiffness, damping=damping, u0=[1.0, 0.0])) == pytest.approx(
            undamped
        )
