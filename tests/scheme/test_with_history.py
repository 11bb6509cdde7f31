"""Schemes on forces with a history: the times at which it is committed, and the errors of the motion."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import study
from reference import piecewise
from study import materials

SPRING = materials.elastoplastic(stiffness=40.0, yield_force=10.0, hardening=0.1)
YIELDING = study.Problem(SPRING, u0=0.2, v0=3.0, damping=0.3, potential=SPRING.potential, title="yielding")
#: Names of schemes whose order is one with damping, or falls to one if the force is not smooth.
FIRST = {name for name, scheme in study.schemes.items() if scheme.order_with_damping == 1} | {"yoshida4", "yoshida6"}
#: Names of schemes with backward sub-steps, in which a force with history unloads, and of extrapolation. Their
#: observed order may lie between one and two.
BACKWARDS = {"yoshida4", "yoshida6", "kahan_li8", "mclachlan4", "extrapolation12"}
#: Name of one scheme of every class.
ONE_OF_EACH = {type(scheme): name for name, scheme in study.schemes.items()}.values()


def _errors(name, problem, steps, duration=4.0, samples=50):
    exact = piecewise.trajectory(problem, np.arange(1, samples + 1) * duration / samples)
    return [
        np.abs(study.run(problem, name, dt=duration / n, steps=n, every=n // samples).u.values[1:] - exact.u).max()
        for n in steps
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ONE_OF_EACH else pytest.mark.exhaustive)
        for name in sorted({*ONE_OF_EACH, *BACKWARDS, *FIRST} - {"energy_momentum"})
    ],
)
def test_no_scheme_has_more_than_order_two_at_yield_points(name):
    """No step ends at a yield point, so the error is of second order in the step size, or of first order."""
    steps = [1600, 3200, 6400, 12800]
    errors = _errors(name, YIELDING, steps)
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order > (0.9 if name in FIRST else 1.6)
    assert order < (1.4 if name in FIRST - BACKWARDS else 2.6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "rk4", "houbolt", "bathe", "noh_bathe"])
def test_a_start_beyond_yield_unloads_elastically(name):
    problem = study.Problem(SPRING, u0=0.6, damping=0.3)
    exact = piecewise.trajectory(problem, np.arange(1, 21) / 5)
    ds = study.run(problem, name, dt=4 / 6400, steps=6400, every=320)
    assert np.abs(ds.u.values[1:] - exact.u).max() < 1e-4


def test_the_model_of_kr_alpha_is_that_of_the_undeformed_structure():
    """The run equals KR-α by hand; its coefficients hold the elastic stiffness, even after the spring has yielded."""
    k, c, dt, rho = 40.0, 0.5, 1.0, 0.8
    spring = materials.elastoplastic(stiffness=k, yield_force=8.0, hardening=0.05)
    ds = study.run(study.Problem(spring, u0=0.0, v0=4.0, damping=c), "kr_alpha", dt=dt, steps=60)
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 0.5 - alpha_m + alpha_f
    model = gamma * dt * c + (0.5 + gamma) ** 2 / 4 * dt**2 * k
    u, v, plastic = 0.0, 4.0, np.zeros(())
    a = -c * v
    for step in range(1, 61):
        forward = a / (1 + model)
        du, dv = dt * v + (0.5 + gamma) * dt**2 * forward, dt * forward
        within = -c * (v + (1 - alpha_f) * dv) - float(spring(u + (1 - alpha_f) * du, 0.0, plastic)[0])
        a = ((1 + model) * within - (alpha_m + alpha_f * model) * a) / (1 - alpha_m + (1 - alpha_f) * model)
        u, v = u + du, v + dv
        plastic = spring(u, 0.0, plastic)[1]
        assert float(ds.u[step]) == pytest.approx(u, abs=1e-12), step


@pytest.mark.slow
def test_the_history_is_committed_once_a_step():
    """The run equals average acceleration by hand, with forces from the history at the end of the last step."""
    dt, steps = 0.05, 60
    ds = study.run(YIELDING, "average_acceleration", dt=dt, steps=steps, observe=["trajectory", "internal_force"])
    u, v, plastic = 0.2, 3.0, np.zeros(())
    force, _ = SPRING(u, v, plastic)
    a = -float(force) - 0.3 * v
    for step in range(1, steps + 1):
        predicted_u, predicted_v = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a
        low, high = -1e4, 1e4
        for _ in range(200):
            a = (low + high) / 2
            force, new = SPRING(predicted_u + dt**2 / 4 * a, 0.0, plastic)
            too_high = a + 0.3 * (predicted_v + dt / 2 * a) + float(force) > 0
            low, high = (low, a) if too_high else (a, high)
        u, v, plastic = predicted_u + dt**2 / 4 * a, predicted_v + dt / 2 * a, new
        assert float(ds.u[step]) == pytest.approx(u, abs=1e-10), step
        assert float(ds.internal_force[step]) == pytest.approx(float(force), abs=1e-9)


def test_sub_steps_commit_where_they_end():
    """Bathe's method commits the history at the end of its first sub-step, a step of the trapezoidal rule."""
    problem, dt = YIELDING, 0.4
    scheme = study.schemes["bathe"]
    start, _ = scheme.start(problem, jnp.asarray(problem.u0), jnp.asarray(problem.v0), jnp.asarray(dt))
    _, effort = jax.jit(scheme.step)(problem, start, 0.0, dt)
    half, _ = jax.jit(study.schemes["average_acceleration"].step)(problem, start, 0.0, dt / 2)
    assert float(effort.committed) == pytest.approx(float(problem.committed(half.u, half.v).history), abs=1e-12)
    assert effort.committed != 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["average_acceleration", "rho_bathe", "rk4"])
@pytest.mark.parametrize("material", ["bouc_wen", "friction"])
def test_other_materials_converge(name, material):
    spring = {
        "bouc_wen": materials.bouc_wen(stiffness=40.0, yield_force=10.0, hardening=0.1),
        "friction": materials.friction(slip_force=10.0, stiffness=400.0),
    }[material]
    problem = study.Problem(spring, u0=0.0, v0=3.0)
    ends = [float(study.run(problem, name, dt=2.0 / n, steps=n, every=n).u[-1]) for n in (500, 1000, 2000, 64_000)]
    errors = np.abs(np.array(ends[:3]) - ends[3])
    assert errors[2] < 1e-4 and errors[0] > errors[2]


def test_lanes_compensated_sums_and_neighbours_remember():
    dt = np.array([0.01, 0.02])
    lanes = study.run(YIELDING, "average_acceleration", dt=dt, steps=100, observe=["energy_balance", "internal_force"])
    for lane, step in enumerate(dt):
        alone = study.run(YIELDING, "average_acceleration", dt=step, steps=100, observe=["internal_force"])
        np.testing.assert_allclose(lanes.internal_force[lane], alone.internal_force, atol=1e-13)
    compensated = study.Compensated(scheme=study.schemes["average_acceleration"])
    ds = study.run(YIELDING, compensated, dt=0.01, steps=100, observe=["lyapunov_exponent", "internal_force"])
    np.testing.assert_allclose(ds.internal_force, lanes.internal_force[0], atol=1e-10)
    # a yielded spring keeps its plastic displacement, so neighbouring runs neither diverge nor meet
    assert abs(float(ds.lyapunov_exponent)) < 2.0


@pytest.mark.slow
def test_a_frame_of_yielding_storeys_under_a_record_converges():
    stiffness, yield_force = np.array([400.0, 350.0, 300.0]), np.array([3.0, 2.5, 2.0])
    storeys = materials.elastoplastic(stiffness=stiffness, yield_force=yield_force)
    force = materials.elements(storeys, lambda u: jnp.diff(u, prepend=0.0), count=3)
    ground = study.GroundMotion.el_centro()
    frame = study.Problem(force, u0=np.zeros(3), damping=0.4, ground=ground, potential=force.potential, title="frame")
    peaks = []
    for part in (1, 2, 16):
        ds = study.run(
            frame,
            "average_acceleration",
            dt=0.02 / part,
            steps=500 * part,
            observe=[
                "energy_balance",
                study.Quantity(lambda u: u[0], reduce="peak", name="drift"),
                "newton_iterations",
            ],
        )
        assert int(ds.status) == 0 and int(ds.max_newton_iterations) < 20
        assert float(ds.dissipated_energy) > 0 and float(ds.max_energy_imbalance) < 1e-11
        peaks.append(float(ds.drift))
    assert abs(peaks[1] - peaks[2]) < abs(peaks[0] - peaks[2]) < 0.1 * peaks[2]
