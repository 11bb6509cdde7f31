"""The structure of the tangent: found, or declared and checked."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy import sparse

import study
from study.algebra.matrices import times
from study.mechanics import tangent
from study.mechanics.sparse_tangent import SparseTangent
from tests.mechanics.forces import all_to_all, chain


@pytest.mark.slow
@pytest.mark.parametrize(
    "force, structure",
    [
        (jnp.sinh, 0),
        (lambda u: u * u * u, 0),
        (chain, 1),
        (all_to_all, "dense"),
        # an unknown is coupled to the one four places away, so that elimination of a band would gain nothing
        (lambda u: u + jnp.roll(u, 4) + jnp.roll(u, -4), "dense"),
    ],
    ids=["uncoupled", "zero at the start", "chain", "all", "far"],
)
def test_the_structure_of_the_tangent_is_found(force, structure):
    assert study.Problem(force, np.zeros(8), np.zeros(8)).tangent == structure


@pytest.mark.slow
def test_an_unknown_without_mass_and_stiffness_needs_pivots():
    """The tangent is dense, because elimination of a band without pivots would divide by the zero on the diagonal."""
    stiffness = 2 * np.eye(8) - np.eye(8, k=1) - np.eye(8, k=-1)
    stiffness[0, 0] = 0
    mass = np.ones(8)
    assert study.Problem(lambda u: stiffness @ u, np.zeros(8), mass=mass).tangent == 1
    mass[0] = 0
    problem = study.Problem(lambda u: stiffness @ u, np.zeros(8), v0=np.append(np.zeros(7), 1.0), mass=mass)
    assert problem.tangent == "dense"
    assert study.run(problem, "bathe", dt=0.1, steps=20).status == 0


def test_few_unknowns_are_eliminated_whole():
    assert study.Problem(chain, np.zeros(4), np.zeros(4)).tangent == "dense"


def test_one_unknown_has_no_structure():
    assert study.Problem(jnp.sin, 0.5).tangent is None


@pytest.mark.slow
@pytest.mark.parametrize(
    "declared, structure",
    [("diagonal", 0), ("tridiagonal", 1), (1, 1), (4, 4), ("dense", "dense"), ("matrix_free", "matrix_free")],
)
def test_a_structure_may_be_declared_that_holds_more(declared, structure):
    problem = study.Problem(jnp.sinh, np.zeros(5), tangent=declared)
    assert problem.tangent == structure


@pytest.mark.slow
def test_of_many_unknowns_the_places_of_the_tangent_are_found():
    many = np.zeros(tangent.FINDABLE + 1)
    assert study.Problem(chain, many).tangent == 1
    wide_tangent = study.Problem(lambda u: chain(u) + u - jnp.roll(u, 5), many).tangent
    assert isinstance(wide_tangent, SparseTangent) and not wide_tangent.pattern.symmetric
    assert study.Problem(chain, many, tangent="tridiagonal").tangent == 1


@pytest.mark.slow
def test_a_structure_is_sought_where_the_force_has_a_derivative():
    """The potential is real only near the start. A coupling of distant unknowns is found; a narrow band is refused."""
    n = 200

    def potential(u):
        return jnp.sum((1 + n * jnp.diff(u)) ** 1.5) / n + 50 * (u[0] - u[100]) ** 2

    assert study.Problem(potential=potential, u0=np.zeros(n)).tangent == "dense"
    with pytest.raises(ValueError, match="has entries outside it"):
        study.Problem(potential=potential, u0=np.zeros(n), tangent="tridiagonal")


@pytest.mark.slow
@pytest.mark.parametrize("opening", [0.02, 20.0])
def test_a_gap_that_is_open_near_the_start_couples_its_unknowns(opening):
    """In metres and in millimetres; the form of the tangent holds the stop between the unknowns 1 and 6."""
    stop = study.materials.elements(
        study.materials.gap(stiffness=2e3, opening=opening), lambda u: (u[1] - u[6])[None], 1
    )
    chain = sparse.diags_array([-1.0, 2.0, -1.0], offsets=(-1, 0, 1), shape=(8, 8), format="csc")
    assert study.Problem(lambda u: stop(u) + u, np.zeros(8)).tangent == "dense"
    pattern = study.Problem(stop, np.zeros(8), stiffness=chain).tangent.pattern
    assert {(1, 6), (6, 1)} & set(zip(pattern.rows.tolist(), pattern.columns.tolist(), strict=True))


@pytest.mark.parametrize("slip", [2e5, 2.0])
def test_the_coupling_of_contacts_that_slip_near_the_start_is_found(slip):
    """Even a small motion makes all contacts slip. The tangent is then diagonal, but their coupling is found."""
    contacts = study.materials.elements(
        study.materials.friction(slip_force=slip, stiffness=1e9), lambda u: u - jnp.pad(u[:-1], (1, 0)), 8
    )

    def force(u, v, history):
        p, history = contacts(u, v, history)
        return 1e7 * u + p, history

    options = {"u0": np.zeros(8), "history": contacts.history, "damping": study.Rayleigh(a=0.0, b=0.02)}
    detected = study.Problem(force, **options)
    assert detected.tangent == 1
    declared = study.Problem(force, tangent="dense", **options)
    v = np.arange(8.0)
    np.testing.assert_allclose(times(detected.damping, v), times(declared.damping, v), rtol=1e-12)
