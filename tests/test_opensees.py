"""The schemes, compared with the integrators of OpenSees, an independent finite element code."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.problem.named import printed_periods
from study.program import opensees_run
from study.scheme.alpha import hht_alpha_1996
from study.scheme.houbolt import History
from tools import opensees

DT, STEPS = printed_periods["hardening"] / 20, 200
IMPLICIT = ("average_acceleration", "newmark_dissipative", "wilson_theta", "hht_alpha", "bathe")


@pytest.fixture
def trajectory():
    """Function that returns the trajectory of OpenSees for a scheme; tests are skipped if OpenSees is not installed."""
    try:
        opensees_run.interpreter()
    except ImportError as reason:
        pytest.skip(str(reason))
    return lambda scheme: opensees.trajectory("hardening", scheme, DT, STEPS)


@pytest.mark.parametrize("scheme", [name for name in opensees.INTEGRATORS if name != "houbolt"])
def test_the_same_definitions_agree_to_round_off(trajectory, scheme):
    ds = study.run("hardening", scheme, dt=DT, steps=STEPS)
    solution = trajectory(scheme)
    np.testing.assert_allclose(solution.u, ds.u[1:], atol=1e-11)
    np.testing.assert_allclose(solution.v, ds.v[1:], atol=1e-9)


@pytest.mark.parametrize("iterations", [4, 6])
def test_its_variable_steps_follow_the_iterations_and_make_the_motion_of_ours(trajectory, iterations):
    period = printed_periods["hardening"]
    t, solution = opensees.variable_steps("hardening", "average_acceleration", 20 * period, DT, period, iterations)
    sizes = np.diff(np.append(0.0, t))
    tests = iterations * sizes[:-1] / sizes[1:]
    free = sizes[1:] < 0.999 * period
    np.testing.assert_allclose(tests[free], np.round(tests[free]), rtol=1e-6)
    ds = study.run(
        "hardening", "average_acceleration", controller=study.Prescribed(sizes), duration=t[-1], observe=["trajectory"]
    )
    np.testing.assert_allclose(ds.u[1:], solution.u, atol=1e-6)


@pytest.mark.parametrize("scheme", IMPLICIT)
def test_the_stiff_and_soft_springs_agree(trajectory, scheme):
    dt = 2 * np.pi / 1.2 / 20
    ds = study.run("stiff_soft", scheme, dt=dt, steps=40)
    solution = opensees.stiff_soft(scheme, dt, 40)
    np.testing.assert_allclose(solution.u, ds.u[1:], atol=1e-8)
    np.testing.assert_allclose(solution.v, ds.v[1:], atol=1e-6)


@pytest.mark.parametrize("scheme", [name for name in opensees.INTEGRATORS if name != "houbolt"])
def test_a_truss_that_spins_agrees(trajectory, scheme):
    """The truss rotates by large angles; it has two cells with both diagonals, six joints and eleven bars."""
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
    ds = study.run(study.Problem(potential=energy, u0=np.zeros(12), v0=v0), scheme, dt=dt, steps=steps)
    solution = opensees.truss(joints, np.stack([first, second], axis=1), rigidity, v0, scheme, dt, steps)
    assert np.abs(ds.u).max() > 1
    np.testing.assert_allclose(solution.u, ds.u[1:], atol=1e-10)
    np.testing.assert_allclose(solution.v, ds.v[1:], atol=1e-9)


@pytest.mark.parametrize("scheme", IMPLICIT)
def test_an_oscillator_that_yields_agrees_step_by_step(trajectory, scheme):
    spring = study.materials.elastoplastic(stiffness=[40.0], yield_force=[4.0], hardening=0.05)
    problem = study.Problem(spring, u0=[0.0], v0=[2.5], history=spring.history)
    ds = study.run(problem, scheme, dt=0.02, steps=300)
    solution = opensees.shear_frame(spring, np.ones(1), scheme, 0.02, 300, v0=np.array([2.5]))
    assert np.abs(ds.u).max() > 3 * 0.1
    np.testing.assert_allclose(solution.u, ds.u[1:], atol=1e-11)
    np.testing.assert_allclose(solution.v, ds.v[1:], atol=1e-10)


@pytest.mark.parametrize("scheme", IMPLICIT)
@pytest.mark.parametrize("exponent", [None, 1.0, 0.5])
def test_a_yielding_frame_under_the_record_agrees_step_by_step(trajectory, scheme, exponent):
    """The frame of examples/yielding_frame.py, without or with dampers; units are N, m, kg and s."""
    dt = 0.01
    ground = study.GroundMotion.el_centro()
    storey = study.materials.elastoplastic(
        stiffness=[4.0e7, 3.5e7, 3.0e7], yield_force=[4.0e5, 3.0e5, 2.0e5], hardening=0.05
    )
    damper = None if exponent is None else study.materials.viscous_damper(coefficient=[5.0e4] * 3, exponent=exponent)

    def drifts(u):
        return u - jnp.pad(u[:-1], (1, 0))

    storeys = study.materials.elements(storey, drifts, 3)
    dampers = None if damper is None else study.materials.elements(damper, drifts, 3)

    def force(u, v, history):
        p, history = storeys(u, v, history)
        return (p if dampers is None else p + dampers(u, v)), history

    mass, steps = np.array([1.0e5, 1.0e5, 0.8e5]), round(12 / dt)
    frame = study.Problem(force, u0=np.zeros(3), history=storeys.history, mass=mass, ground=ground)
    ds = study.run(frame, scheme, dt=dt, steps=steps)
    solution = opensees.shear_frame(storey, mass, scheme, dt, steps, dampers=damper, ground=ground)
    np.testing.assert_allclose(solution.u, ds.u[1:], atol=1e-11)


def test_smooth_hysteresis_agrees_as_the_step_of_opensees_falls(trajectory):
    """OpenSees integrates the law implicitly, with an error of first order; the study has the law in closed form."""
    spring = study.materials.bouc_wen(stiffness=[40.0], yield_force=[4.0], hardening=0.05)
    problem = study.Problem(spring, u0=[0.0], v0=[2.5], history=spring.history)
    exact = study.run(problem, "average_acceleration", dt=1e-4, steps=20_000, every=2_000).u[1:]
    errors = []
    for part in (20, 80):
        solution = opensees.shear_frame(
            spring, np.ones(1), "average_acceleration", 0.2 / part, 10 * part, v0=np.array([2.5])
        )
        errors.append(float(np.abs(solution.u[part - 1 :: part] - exact).max()))
    assert errors[1] < 0.01 * float(np.abs(exact).max()) and 3 < errors[0] / errors[1]


def test_houbolts_recurrence_is_the_same_and_its_start_is_not(trajectory):
    """OpenSees makes two steps of average acceleration first; from there its displacements follow our recurrence."""
    problem, houbolt = study.problems["hardening"], study.schemes["houbolt"]
    u = np.concatenate([[float(problem.u0)], trajectory("houbolt").u])
    average = study.run("hardening", "average_acceleration", dt=DT, steps=2)
    np.testing.assert_allclose(u[1:3], average.u[1:3], atol=1e-12)
    for i in range(3, 30):
        state = History(u[i - 1], 0.0, -problem.force(u[i - 1]), u[i - 2], u[i - 3])
        assert houbolt.step(problem, state, 0.0, DT)[0].u == pytest.approx(u[i], abs=1e-11)
    assert abs(study.run("hardening", "houbolt", dt=DT, steps=STEPS).u[1:] - u[1:]).max() > 1e-3


def test_the_alpha_method_of_finite_elements_weights_displacements(trajectory):
    """The balance of OpenSees is M ü₁ + p((1 + α) u₁ − α u₀) = 0; the balance of 1996 weights two forces instead."""
    problem, scheme = study.problems["hardening"], hht_alpha_1996
    u = np.concatenate([[float(problem.u0)], trajectory("hht_alpha").u])
    v = np.concatenate([[0.0], trajectory("hht_alpha").v])
    a = -float(problem.force(u[0]))
    for i in range(1, 30):
        new = (u[i] - u[i - 1] - DT * v[i - 1] - DT**2 * (0.5 - scheme.beta) * a) / (scheme.beta * DT**2)
        weighted = problem.force((1 + scheme.alpha) * u[i] - scheme.alpha * u[i - 1])
        two = (1 + scheme.alpha) * problem.force(u[i]) - scheme.alpha * problem.force(u[i - 1])
        assert new == pytest.approx(-weighted, abs=1e-6 * 3525)
        a = new
    assert abs(weighted - two) > 1


def test_what_opensees_cannot_do_says_so(trajectory):
    with pytest.raises(ValueError, match="OpenSees has no material for the spring of 'softening spring'"):
        opensees.trajectory("softening", "houbolt", DT, 1)
    with pytest.raises(ValueError, match="OpenSees has no integrator for 'rk4', only for average_acceleration"):
        opensees.trajectory("hardening", "rk4", DT, 1)


def test_without_opensees_a_sentence_says_how_to_get_it(monkeypatch):
    def absent(name):
        raise RuntimeError("Failed to import openseespy on Linux.")

    monkeypatch.setattr(opensees_run.importlib, "import_module", absent)
    with pytest.raises(ImportError, match=r"install the extra 'opensees' of this package.*Failed to import"):
        opensees_run.interpreter()
