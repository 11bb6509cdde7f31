"""Observed orders of all schemes equal the claimed ones, for free, damped and forced motion of one or two unknowns."""

import jax.numpy as jnp
import numpy as np
import pytest

import study

#: Numbers of steps by expected order, for which errors are in the asymptotic range and above round-off.
STEPS = {
    1: [6400, 12800, 25600],
    2: [800, 1600, 3200],
    3: [1300, 2600, 5200],
    4: [80, 160, 320],
    6: [60, 85, 120],
    8: [20, 28, 40],
}


#: Extrapolation of order 6, tested in place of order 12. Errors of order 12 reach round-off before an order can be
#: fitted, but linear theory shows this order.
SIXTH = study.Extrapolation(sequence=(1, 2, 3))


@pytest.fixture
def scheme(scheme):
    """Every scheme in turn; ``SIXTH`` replaces the scheme of order 12."""
    return SIXTH if scheme.order == 12 else scheme


def _driven_along(exact, damping=None, mass=None):
    """A problem whose load makes the chosen motion its exact solution."""
    u0, v0, _ = exact(0.0)
    coupling = jnp.asarray([[2.0, -1.0], [-1.0, 3.0]]) if jnp.ndim(u0) else 2.0

    def force(u):
        return (coupling @ u if jnp.ndim(u) else coupling * u) + u**3

    def load(t):
        u, v, a = exact(t)
        inertia = a if mass is None else jnp.asarray(mass) @ a if np.ndim(mass) == 2 else mass * a
        resistance = 0.0 if damping is None else jnp.asarray(damping) @ v if np.ndim(damping) == 2 else damping * v
        return inertia + resistance + force(u)

    def potential(u):
        return (u @ coupling @ u / 2 if jnp.ndim(u) else u**2) + jnp.sum(u**4) / 4

    return study.Problem(force, u0, v0, potential=potential, load=load, damping=damping, mass=mass, title="driven")


def motion(t):
    return jnp.cos(t) + 0.3 * jnp.sin(2 * t), -jnp.sin(t) + 0.6 * jnp.cos(2 * t), -jnp.cos(t) - 1.2 * jnp.sin(2 * t)


def _two(t):
    u, v, a = motion(t)
    return (
        jnp.stack([u, 0.5 * jnp.cos(0.7 * t)]),
        jnp.stack([v, -0.35 * jnp.sin(0.7 * t)]),
        jnp.stack([a, -0.245 * jnp.cos(0.7 * t)]),
    )


def _observed_orders(problem, scheme, exact, duration, steps):
    errors = []
    for n in steps:
        end = study.run(problem, scheme, dt=duration / n, steps=n, every=n).isel(t=-1)
        errors.append(np.max(np.abs(end.u.values - np.asarray(exact(duration)[0]))))
    return -np.diff(np.log(errors)) / np.diff(np.log(steps))


@pytest.fixture(scope="module")
def driven():
    return _driven_along(motion, damping=0.3)


@pytest.fixture(scope="module")
def driven_pair():
    return _driven_along(_two, damping=np.diag([0.2, 0.4]) + 0.1, mass=np.array([[2.0, 0.5], [0.5, 1.0]]))


@pytest.mark.slow
def test_order_of_one_damped_and_driven_oscillator(driven, scheme):
    orders = _observed_orders(driven, scheme, motion, 3.0, STEPS[scheme.order_with_damping])
    assert orders == pytest.approx(scheme.order_with_damping, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mclachlan4", "blanes_moan4", "dormand_prince6"])
def test_a_load_alone_leaves_a_method_its_order(name):
    """These methods assume an acceleration that does not depend on the velocity; a load alone keeps their order."""
    scheme = study.schemes[name]
    assert scheme.order_with_damping < scheme.order
    orders = _observed_orders(_driven_along(motion), scheme, motion, 3.0, STEPS[scheme.order])
    assert orders == pytest.approx(scheme.order, abs=0.1)


@pytest.mark.slow
def test_order_of_two_coupled_unknowns(driven_pair, sampled_kind):
    scheme = SIXTH if study.schemes[sampled_kind].order == 12 else study.schemes[sampled_kind]
    steps = STEPS[scheme.order_with_damping]
    orders = _observed_orders(driven_pair, scheme, _two, 3.0, steps)
    assert orders == pytest.approx(scheme.order_with_damping, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, order", [("hht_alpha_1996", 2), ("blanes_moan4", 4), ("mclachlan4", 4), ("fox_goodwin", 4)]
)
def test_a_free_spring_without_damping_shows_the_order_that_damping_costs(name, order):
    """In free undamped motion from rest, Fox and Goodwin's displacements are those of Numerov's formula, of order 4."""
    period = 0.151532834447260357127078726219
    # from rest alone, Fox and Goodwin's method exceeds its order
    assert study.schemes[name].order == (2 if name == "fox_goodwin" else order)
    assert order > study.schemes[name].order_with_damping
    counts = {2: [1600, 3200, 6400], 4: [50, 100, 200]}[order]
    # after a quarter of the period the exact displacement is zero
    errors = [abs(study.run("hardening", name, dt=period / 4 / n, steps=n, every=n).u.values[-1]) for n in counts]
    assert -np.diff(np.log(errors)) / np.diff(np.log(counts)) == pytest.approx(order, abs=0.1)
