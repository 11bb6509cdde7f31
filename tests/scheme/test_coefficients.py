"""The coefficients that the article prints for the schemes of 1996, compared with the schemes of the study.

Every implicit step is u₁ = ũ + c_u a, u̇₁ = ṽ + c_v a with M a + C (ṽ + c_v a) + w p(ũ + c_u a) = r. The tests use the
formulas of the article's table, on a damped and loaded cubic spring.
"""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

import study

MASS, DAMPING, DT = 2.0, 0.3, 0.05


def force(u):
    return u + 2 * u**3


def load(t):
    return np.sin(t)


PROBLEM = study.Problem(force, u0=0.7, v0=-0.4, mass=MASS, damping=DAMPING, load=jnp.sin)


def balanced(u, v, c_u, c_v, w, r):
    """The acceleration a that balances the forces."""
    return brentq(
        lambda a: MASS * a + DAMPING * (v + c_v * a) + w * force(u + c_u * a) - r, -1e3, 1e3, xtol=1e-14, rtol=1e-15
    )


def newmark(state, t, dt, beta, gamma, w=1.0, r=None):
    u, v, a = state
    u_predicted = u + dt * v + dt**2 * (0.5 - beta) * a
    v_predicted = v + dt * (1 - gamma) * a
    new = balanced(u_predicted, v_predicted, beta * dt**2, gamma * dt, w, load(t + dt) if r is None else r)
    return u_predicted + beta * dt**2 * new, v_predicted + gamma * dt * new, new


def wilson(state, t, theta=1.4, beta=1 / 6, gamma=0.5):
    u, v, a = state
    *_, a_theta = newmark(state, t, theta * DT, beta, gamma)
    new = (1 - 1 / theta) * a + a_theta / theta
    u_new = u + DT * v + DT**2 * ((0.5 - beta) * a + beta * new)
    return u_new, v + DT * ((1 - gamma) * a + gamma * new), new


def alpha(state, t, alpha=-0.1):
    return newmark(state, t, DT, 0.3025, 0.6, 1 + alpha, load(t + DT) + alpha * force(state[0]))


STEPS = {
    "average_acceleration": lambda state, t: newmark(state, t, DT, 0.25, 0.5),
    "central_difference": lambda state, t: newmark(state, t, DT, 0.0, 0.5),
    "newmark_dissipative": lambda state, t: newmark(state, t, DT, 0.3025, 0.6),
    "wilson_theta": wilson,
    "hht_alpha_1996": alpha,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", STEPS)
def test_one_step_methods(name):
    state = (0.7, -0.4, (load(0.0) - DAMPING * -0.4 - force(0.7)) / MASS)
    ds = study.run(PROBLEM, name, dt=DT, steps=20, observe=["trajectory"])
    for k in range(20):
        state = STEPS[name](state, k * DT)
        np.testing.assert_allclose((ds.u.values[k + 1], ds.v.values[k + 1]), state[:2], rtol=1e-11)


def test_houbolt():
    ds = study.run(PROBLEM, "houbolt", dt=DT, steps=20, observe=["trajectory"])
    u, v = ds.u.values, ds.v.values
    for k in range(3, 20):
        predicted = (5 * u[k] - 4 * u[k - 1] + u[k - 2]) / 2
        v_predicted = (11 * predicted - 18 * u[k] + 9 * u[k - 1] - 2 * u[k - 2]) / (6 * DT)
        c_u, c_v = DT**2 / 2, 11 * DT / 12
        a = balanced(predicted, v_predicted, c_u, c_v, 1.0, load((k + 1) * DT))
        np.testing.assert_allclose((u[k + 1], v[k + 1]), (predicted + c_u * a, v_predicted + c_v * a), rtol=1e-10)
