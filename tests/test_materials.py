"""Materials, compared with closed forms and independent integration, and the rules for forces with a history."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
from hypothesis import given, settings
from hypothesis import strategies as st

import study
from study import materials

REMEMBER: dict[str, Any] = {
    "elastoplastic": materials.elastoplastic(stiffness=4.0, yield_force=1.0, hardening=0.1),
    "friction": materials.friction(slip_force=0.5, stiffness=50.0),
    "bouc_wen_1": materials.bouc_wen(stiffness=4.0, yield_force=1.0, hardening=0.05),
    "bouc_wen_2": materials.bouc_wen(stiffness=4.0, yield_force=1.0, exponent=2),
}
paths = st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=8)


def _along(material, path, history=None):
    """Forces at the points of a path, and the last history; the history is committed at every point."""
    history, forces = material.history if history is None else history, []
    for u in path:
        force, history = jax.jit(material)(jnp.asarray(u), jnp.asarray(0.0), history)
        forces.append(float(force))
    return np.array(forces), history


@pytest.mark.slow
@pytest.mark.parametrize("name", REMEMBER)
@settings(max_examples=40, deadline=None)
@given(path=paths)
def test_a_committed_state_gives_its_force_again(name, path):
    material = REMEMBER[name]
    forces, history = _along(material, path)
    again, same = _along(material, path[-1:], history)
    assert again[0] == pytest.approx(forces[-1], abs=1e-12)
    for value, other in zip(jax.tree.leaves(history), jax.tree.leaves(same), strict=True):
        assert float(value) == pytest.approx(float(other), abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", REMEMBER)
@settings(max_examples=40, deadline=None)
@given(path=paths, parts=st.integers(2, 7))
def test_a_way_in_parts_is_the_way_at_once(name, path, parts):
    """The force of a rate-independent material depends on the turning points of the path only."""
    material, between, last = REMEMBER[name], [], 0.0
    for u in path:
        between += np.linspace(last, u, parts + 1)[1:].tolist()
        last = u
    assert _along(material, between)[0][parts - 1 :: parts] == pytest.approx(_along(material, path)[0], abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["elastoplastic", "friction"])
def test_a_cycle_dissipates_the_area_of_its_parallelogram(name):
    material, amplitude = REMEMBER[name], 1.5
    k, fy, b = (float(x) for x in (material.stiffness, material.yield_force, material.hardening))
    way = np.linspace(amplitude, -amplitude, 401)
    path = np.concatenate([[amplitude], way, way[::-1]])
    forces, _ = _along(material, path)
    area = np.trapezoid(forces[1:], path[1:])
    assert area == pytest.approx(4 * (1 - b) * fy * (amplitude - fy / k), rel=1e-2)


@pytest.mark.parametrize("exponent", [1, 2])
@pytest.mark.parametrize("ends", [(2.0, -2.0, 0.7), (-0.1, 0.3, -0.05)])
def test_bouc_wen_solves_its_equation(exponent, ends):
    material = materials.bouc_wen(stiffness=4.0, yield_force=1.0, hardening=0.05, exponent=exponent)
    bound, z, last, expected = 0.25, 0.0, 0.0, []
    for end in ends:
        sign = np.sign(end - last)

        def slope(u, z, sign=sign):
            return 1 - 0.5 * np.abs(z / bound) ** exponent * (1 + np.sign(z * sign))

        grid = scipy.integrate.solve_ivp(
            slope, (last, end), [z], method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.02
        )
        z, last = grid.y[0, -1], end
        expected.append(4.0 * (0.05 * end + 0.95 * z))
    assert _along(material, ends)[0] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("name", ["elastoplastic", "friction"])
def test_the_force_is_the_slope_of_the_stored_energy_while_elastic(name):
    material = REMEMBER[name]
    _, plastic = _along(material, [1.0, 0.995])
    slope = jax.grad(material.potential)(jnp.asarray(0.995), plastic)
    assert float(slope) == pytest.approx(_along(material, [0.995], plastic)[0][0], rel=1e-12)


@pytest.mark.slow
def test_a_damper_and_a_gap():
    damper, stop = materials.viscous_damper(coefficient=3.0, exponent=0.5), materials.gap(stiffness=10.0, opening=0.2)
    v = jnp.asarray([-4.0, 0.0, 9.0])
    assert damper(v, v).tolist() == [-6.0, 0.0, 9.0]
    assert np.isfinite(jax.vmap(jax.grad(damper, argnums=1))(v, v)).all()
    at_rest = [
        jax.grad(materials.viscous_damper(coefficient=3.0, exponent=power), argnums=1)(0.0, 0.0)
        for power in (0.5, 1.0, 2.0)
    ]
    assert at_rest == [0.0, 3.0, 0.0]
    assert stop(jnp.asarray([0.1, 0.2, 0.5])) == pytest.approx([0.0, 0.0, 3.0])


def test_elements_assemble_nodal_forces():
    """Nodal forces of three storeys are differences of storey forces, and every storey has its own history."""
    storey = materials.elastoplastic(stiffness=np.array([4.0, 3.0, 2.0]), yield_force=1.0)
    force = materials.elements(storey, lambda u: jnp.diff(u, prepend=0.0), count=3)
    u, v = jnp.asarray([1.0, 0.9, 1.5]), jnp.zeros(3)
    nodal, plastic = force(u, v, force.history)
    in_storeys, expected = storey(jnp.diff(u, prepend=0.0), v, np.zeros(3))
    assert nodal == pytest.approx(np.append(in_storeys[:-1] - in_storeys[1:], in_storeys[-1]))
    assert plastic == pytest.approx(expected)
    frame = study.Problem(force, u0=np.zeros(3), v0=np.ones(3), potential=force.potential)
    assert frame.kinked and not frame.takes_velocity
    damped = materials.elements(materials.viscous_damper(coefficient=0.5), lambda u: jnp.diff(u, prepend=0.0), count=3)
    assert study.Problem(damped, u0=np.zeros(3)).takes_velocity
    stops = materials.elements(materials.gap(stiffness=5.0, opening=0.1), lambda u: jnp.diff(u, prepend=0.0), count=3)
    assert study.Problem(stops, u0=np.zeros(3), potential=stops.potential).arguments == 1


@pytest.mark.parametrize(
    "make, sentence",
    [
        (
            lambda: materials.elastoplastic(stiffness=4.0, yield_force=0.0),
            "yield_force must be a number greater than 0, not 0.0",
        ),
        (lambda: materials.elastoplastic(stiffness=-4.0, yield_force=1.0), "stiffness must be a number greater than 0"),
        (
            lambda: materials.elastoplastic(stiffness=4.0, yield_force=1.0, hardening=1.5),
            "hardening must be a number at least 0 and at most 1, not 1.5",
        ),
        (lambda: materials.elastoplastic(stiffness=4.0, yield_force="a"), "yield_force must be a number"),
        (
            lambda: materials.bouc_wen(stiffness=4.0, yield_force=1.0, exponent=3),
            "exponent must be 1 or 2, for which the law has",
        ),
        (lambda: materials.viscous_damper(coefficient=-1.0), "coefficient must be a number at least 0"),
        (
            lambda: materials.viscous_damper(coefficient=1.0, exponent=0.0),
            "exponent must be a number greater than 0 and at most 2",
        ),
        (lambda: materials.gap(stiffness=1.0, opening=np.nan), "opening must be a number"),
        (lambda: materials.elements(REMEMBER["friction"], jnp.diff, count=0), "count must be a whole number"),
        (
            lambda: materials.elastoplastic(stiffness=[1.0, 2.0], yield_force=[1.0, 2.0, 3.0]),
            r"one shape, a value for each element, not stiffness \(2,\), yield_force \(3,\), hardening \(\)",
        ),
        (
            lambda: materials.gap(stiffness=[1.0, 2.0], opening=np.zeros(3)),
            "arrays of one shape, a value for each element",
        ),
        (
            lambda: materials.elements(materials.gap(stiffness=1.0), jnp.diff, count=3)(jnp.zeros(3)),
            r"elongations of 3 elements must return the shape \(3,\), not \(2,\)",
        ),
        (
            lambda: materials.elements(
                materials.elastoplastic(stiffness=[1.0, 2.0], yield_force=1.0), jnp.diff, count=3
            ),
            r"3 elements need a material with numbers or arrays \(3,\), not Elastoplastic",
        ),
    ],
)
def test_a_parameter_out_of_range_is_refused(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()


@pytest.mark.parametrize(
    "force, history, sentence",
    [
        (lambda u, v, h: u, 0.0, "must return the force and its new history, a tuple of two"),
        (lambda u, v, h: (u, (h, h)), 0.0, "must return a history with the containers, shapes"),
        (
            lambda u, v, h: (u, jnp.zeros(2)),
            0.0,
            "must return a history with the containers, shapes and types of its start",
        ),
        (lambda u, v, h: (u, h), "a", "must be arrays of real numbers, in any containers, not 'a'"),
        (lambda u, v, h: (u, h), np.nan, "the history of 'own' must be finite"),
        (lambda u, v: u, 0.0, "takes 2 arguments, and the problem has a history"),
        (lambda u, v, h: (u + h, h + 0.1 * u), 0.0, "gives another force when it is called again with the same"),
        (lambda u, v, h: (u, h + 1.0), 0.0, "gives another history when it is called again with the same"),
    ],
)
def test_a_force_that_forgets_is_refused(force, history, sentence):
    with pytest.raises(ValueError, match=sentence):
        study.Problem(force, u0=1.0, history=history, title="own")


def test_springs_that_differ_in_numbers_are_checked_by_one_program(compiled):
    springs = [materials.elastoplastic(stiffness=k, yield_force=1.0, hardening=0.1) for k in (4.0, 5.0)]
    study.Problem(springs[0], u0=1.0)
    before = len(compiled)
    study.Problem(springs[1], u0=1.0)
    assert 0 < before == len(compiled)


def test_a_force_is_checked_again_if_what_it_reads_has_changed():
    added = [0.0]

    def force(u, v, history):
        return u, history + added[0]

    study.Problem(force, u0=1.0, history=0.0)
    added[0] = 1.0
    with pytest.raises(ValueError, match="gives another history"):
        study.Problem(force, u0=1.0, history=0.0)


@pytest.mark.parametrize(
    "force, name",
    [
        (lambda u, v=0.0: u + v, "v"),
        (lambda u, velocity=0.0: u + velocity, "velocity"),
        (lambda u, v, history=0.0: (u, history), "history"),
    ],
)
def test_an_argument_with_a_default_that_the_motion_would_never_give_is_refused(force, name):
    with pytest.raises(ValueError, match=f"gives '{name}' a default, and would never be called with another value"):
        study.Problem(force, u0=1.0, title="own")


def test_a_constant_may_be_bound_by_a_default():
    assert study.Problem(lambda u, k=3.0: k * u, u0=1.0).arguments == 1


@pytest.mark.parametrize("factor", [1.0, 0.5, -1.0])
def test_a_stored_energy_is_compared_with_the_force_after_a_reversal(factor):
    spring = materials.elements(
        materials.elastoplastic(stiffness=[4.0, 5.0], yield_force=[0.3, 0.2], hardening=0.1), jnp.asarray, 2
    )
    if factor == 1.0:
        study.Problem(spring, u0=np.zeros(2), potential=spring.potential)
        return
    with pytest.raises(ValueError, match="the force of 'own' is not the gradient of its potential"):
        study.Problem(spring, u0=np.zeros(2), potential=lambda u, h: factor * spring.potential(u, h), title="own")
