"""Every scheme converges with the order that it claims, free, damped and forced, with one unknown and with two."""

import jax.numpy as jnp
import numpy as np
import pytest

import study

#: Steps within the asymptotic range and above round-off, by expected order.
STEPS = {1: [6400, 12800, 25600], 2: [800, 1600, 3200], 4: [80, 160, 320]}


def _driven_along(exact, damping=None, mass=None):
    """A problem whose exact solution is known: the load is what the chosen motion needs."""
    u0, v0, _ = exact(0.0)
    coupling = jnp.asarray([[2.0, -1.0], [-1.0, 3.0]]) if jnp.ndim(u0) else 2.0

    def force(u):
        return (coupling @ u if jnp.ndim(u) else coupling * u) + u**3

    def load(t):
        u, v, a = exact(t)
        inertia = a if mass is None else jnp.asarray(mass) @ a if np.ndim(mass) == 2 else mass * a
        resistance = 0.0 if damping is None else jnp.asarray(damping) @ v if np.ndim(damping) == 2 else damping * v
        return inertia + resistance + force(u)

    return study.Problem(force=force, u0=u0, v0=v0, load=load, damping=damping, mass=mass, title="driven")


def _one(t):
    return jnp.cos(t) + 0.3 * jnp.sin(2 * t), -jnp.sin(t) + 0.6 * jnp.cos(2 * t), -jnp.cos(t) - 1.2 * jnp.sin(2 * t)


def _two(t):
    u, v, a = _one(t)
    return (
        jnp.stack([u, 0.5 * jnp.cos(0.7 * t)]),
        jnp.stack([v, -0.35 * jnp.sin(0.7 * t)]),
        jnp.stack([a, -0.245 * jnp.cos(0.7 * t)]),
    )


def _observed_orders(problem, scheme, exact, duration, steps):
    errors = []
    for n in steps:
        end = study.run(problem, scheme, dt=duration / n, steps=n).isel(t=-1)
        errors.append(np.max(np.abs(end.u.values - np.asarray(exact(duration)[0]))))
    return -np.diff(np.log(errors)) / np.diff(np.log(steps))


@pytest.mark.parametrize("damping, mass", [(None, None), (0.4, 1.5)])
def test_order_of_one_driven_oscillator(scheme_name, damping, mass):
    scheme = study.schemes[scheme_name]
    # eq. (12) weights neither damping nor load, so that the α-method is of first order where there are any
    expected = 1 if scheme_name == "hht_alpha" else scheme.order
    steps = STEPS[expected]
    orders = _observed_orders(_driven_along(_one, damping, mass), scheme, _one, 3.0, steps)
    assert orders == pytest.approx(expected, abs=0.1)


def test_order_of_two_coupled_unknowns(scheme_name):
    scheme = study.schemes[scheme_name]
    expected = 1 if scheme_name == "hht_alpha" else scheme.order
    problem = _driven_along(_two, damping=np.diag([0.2, 0.4]) + 0.1, mass=np.array([[2.0, 0.5], [0.5, 1.0]]))
    steps = STEPS[expected]
    orders = _observed_orders(problem, scheme, _two, 3.0, steps)
    assert orders == pytest.approx(expected, abs=0.1)


def test_order_on_the_hardening_spring(scheme):
    """Free and undamped, the α-method has its second order."""
    period = 0.151532834447260357127078726219
    steps = [1600, 3200, 6400] if scheme.order < 4 else [100, 200, 400]
    # after a quarter of the period the exact displacement is zero
    errors = [abs(study.run("hardening", scheme, dt=period / 4 / n, steps=n).u.values[-1]) for n in steps]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(scheme.order, abs=0.1)
