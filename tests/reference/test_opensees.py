"""The schemes against those of OpenSees, an independent finite element code."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from reference import opensees
from study.problem.named import printed_periods
from study.scheme.alpha import hht_alpha
from study.scheme.houbolt import History

DT, STEPS = printed_periods["hardening"] / 20, 200


@pytest.fixture
def theirs():
    """Trajectory of OpenSees by scheme; skipped with a sentence where it is not installed."""
    try:
        opensees.load()
    except opensees.NotInstalled as reason:
        pytest.skip(str(reason))
    return lambda scheme: opensees.trajectory("hardening", scheme, DT, STEPS)


@pytest.mark.parametrize("scheme", [name for name in opensees.INTEGRATORS if name not in ("houbolt", "hht_alpha")])
def test_the_same_definitions_agree_to_round_off(theirs, scheme):
    ours = study.run("hardening", scheme, dt=DT, steps=STEPS)
    solution = theirs(scheme)
    np.testing.assert_allclose(solution.u, ours.u[1:], atol=1e-11)
    np.testing.assert_allclose(solution.v, ours.v[1:], atol=1e-9)


@pytest.mark.parametrize(
    "scheme", ["average_acceleration", "newmark_dissipative", "wilson_theta", "hht_alpha_one_force", "bathe"]
)
def test_the_stiff_and_soft_springs_agree(theirs, scheme):
    dt = 2 * np.pi / 1.2 / 20
    ours = study.run("stiff_soft", scheme, dt=dt, steps=40)
    solution = opensees.stiff_soft(scheme, dt, 40)
    np.testing.assert_allclose(solution.u, ours.u[1:], atol=1e-8)
    np.testing.assert_allclose(solution.v, ours.v[1:], atol=1e-6)


@pytest.mark.parametrize("scheme", [name for name in opensees.INTEGRATORS if name not in ("houbolt", "hht_alpha")])
def test_a_truss_that_spins_agrees(theirs, scheme):
    """Large rotations: two cells with both diagonals, six joints, eleven bars."""
    joints = np.array([[x, y] for x in (-1.0, 0.0, 1.0) for y in (-0.5, 0.5)])
    first, second = np.triu_indices(6, 1)
    near = np.linalg.norm(joints[second] - joints[first], axis=1) < 1.5
    first, second = first[near], second[near]
    assert len(first) == 11
    length, rigidity, dt, steps = np.linalg.norm(joints[second] - joints[first], axis=1), 100.0, 0.02, 200
    v0 = np.stack([-joints[:, 1], joints[:, 0]], axis=1).ravel()

    def strains(u):
        places = joints + u.reshape(joints.shape)
        return jnp.linalg.norm(places[second] - places[first], axis=1) / length - 1

    energy = study.StrainEnergy(strains, lambda e: rigidity * length * e**2 / 2)
    ours = study.run(study.Problem(potential=energy, u0=np.zeros(12), v0=v0), scheme, dt=dt, steps=steps)
    solution = opensees.truss(joints, np.stack([first, second], axis=1), rigidity, v0, scheme, dt, steps)
    assert np.abs(ours.u).max() > 1
    np.testing.assert_allclose(solution.u, ours.u[1:], atol=1e-10)
    np.testing.assert_allclose(solution.v, ours.v[1:], atol=1e-9)


def test_houbolts_recurrence_is_the_same_and_its_start_is_not(theirs):
    """OpenSees starts it by two steps of average acceleration; from there each of its points follows from ours."""
    problem, houbolt = study.problems["hardening"], study.schemes["houbolt"]
    u = np.concatenate([[float(problem.u0)], theirs("houbolt").u])
    average = study.run("hardening", "average_acceleration", dt=DT, steps=2)
    np.testing.assert_allclose(u[1:2], average.u[1:2], atol=1e-12)
    for i in range(3, 30):
        state = History(u[i - 1], 0.0, -problem.force(u[i - 1]), u[i - 2], u[i - 3])
        assert houbolt.step(problem, state, 0.0, DT)[0].u == pytest.approx(u[i], abs=1e-11)
    assert abs(study.run("hardening", "houbolt", dt=DT, steps=STEPS).u[1:] - u[1:]).max() > 1e-3


def test_the_alpha_method_of_finite_elements_weights_displacements(theirs):
    """Its balance is M ü₁ + p((1 + α) u₁ − α u₀) = 0, not the one of 1996, which weights two forces."""
    problem, scheme = study.problems["hardening"], hht_alpha
    u = np.concatenate([[float(problem.u0)], theirs("hht_alpha").u])
    v = np.concatenate([[0.0], theirs("hht_alpha").v])
    a = -float(problem.force(u[0]))
    for i in range(1, 30):
        new = (u[i] - u[i - 1] - DT * v[i - 1] - DT**2 * (0.5 - scheme.beta) * a) / (scheme.beta * DT**2)
        weighted = problem.force((1 + scheme.alpha) * u[i] - scheme.alpha * u[i - 1])
        two = (1 + scheme.alpha) * problem.force(u[i]) - scheme.alpha * problem.force(u[i - 1])
        assert new == pytest.approx(-weighted, abs=1e-6 * 3525)
        a = new
    assert abs(weighted - two) > 1


def test_what_opensees_cannot_do_says_so(theirs):
    with pytest.raises(ValueError, match="OpenSees has no material for the spring of 'softening spring'"):
        opensees.trajectory("softening", "houbolt", DT, 1)
    with pytest.raises(ValueError, match="OpenSees does not step 'rk4'; it steps average_acceleration"):
        opensees.trajectory("hardening", "rk4", DT, 1)


def test_without_opensees_a_sentence_says_how_to_get_it(monkeypatch):
    def absent(name):
        raise RuntimeError("Failed to import openseespy on Linux.")

    monkeypatch.setattr(opensees.importlib, "import_module", absent)
    with pytest.raises(opensees.NotInstalled, match=r"install the extra 'opensees' of this package.*Failed to import"):
        opensees.load()
