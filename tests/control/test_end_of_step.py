"""The force at the end of a controlled step, which some schemes do not evaluate."""

import jax.numpy as jnp
import numpy as np
import pytest

import study
from study.marching import control
from study.scheme.named import schemes

#: Gravity, and the stiffness of the floor.
G, FLOOR = 9.81, 1e5
#: A mass of 1 kg that falls 2 m on an elastic floor.
FALL = study.Problem(lambda u: jnp.where(u < 0, FLOOR * u, 0.0), u0=2.0, load=lambda t: -G, title="fall")
#: Depth at which the potential of gravity has become the energy of the floor.
DEPTH = G / FLOOR + np.sqrt((G / FLOOR) ** 2 + 2 * G * 2.0 / FLOOR)

SPECIFIC = study.Quantity(
    lambda u, v: v**2 / 2 + G * u + jnp.where(u < 0, FLOOR * u**2 / 2, 0.0), name="energy", reduce="peak"
)
DEEPEST = study.Quantity(lambda u: jnp.maximum(-u, 0.0), name="deepest", reduce="peak")


@pytest.mark.parametrize("name", [name for name, scheme in schemes.items() if not scheme.needs_equal_steps])
def test_the_declared_use_of_the_force_at_the_end(name):
    """The force is zero but for the last hundredth of a step from u = 0 to u = 1."""
    scheme = schemes[name]
    push = study.Problem(
        lambda u: jnp.where(u > 0.99, 1e-6, 0.0), 0.0, 1.0, potential=lambda u: 1e-6 * jnp.maximum(u - 0.99, 0.0)
    )
    start, _ = scheme.start(push, jnp.zeros(()), jnp.ones(()), 1.0)
    end, _ = scheme.step(push, start, 0.0, 1.0)
    pushed = abs(float(jnp.ravel(end.u)[0]) - 1) + abs(float(jnp.ravel(end.v)[0]) - 1) > 1e-12
    if name != "extrapolation12":  # its estimate is a 4095th of a difference, so the end is compared all the same
        assert scheme.force_at_end == pushed


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, estimator",
    [
        ("generalized_alpha", None),
        ("generalized_alpha", "three_point"),
        ("average_acceleration", None),
        pytest.param("generalized_alpha", "half_step_residual", marks=pytest.mark.exhaustive),
        pytest.param("generalized_alpha", "step_doubling", marks=pytest.mark.exhaustive),
        pytest.param("hht_alpha", None, marks=pytest.mark.exhaustive),
        pytest.param("implicit_midpoint", None, marks=pytest.mark.exhaustive),
        pytest.param("gauss4", None, marks=pytest.mark.exhaustive),
        pytest.param("hulbert_chung", None, marks=pytest.mark.exhaustive),
        pytest.param("extrapolation12", None, marks=pytest.mark.exhaustive),
    ],
)
def test_a_controlled_step_does_not_end_inside_the_floor(name, estimator):
    tolerance = np.array([1e-3, 1e-5, 1e-7])
    ds = study.run(FALL, name, tolerance=tolerance, duration=5.0, estimator=estimator, observe=[SPECIFIC, DEEPEST])
    assert (ds.status == 0).all()
    # the energy is quadratic in the velocity, and there are four impacts
    np.testing.assert_allclose(ds.energy, 2 * G, rtol=0.2)
    np.testing.assert_allclose(ds.energy[1:], 2 * G, rtol=0.005)
    # the tolerance is relative to the height; the depth is known at ends of steps, so it may also be missed
    assert (ds.deepest < 1.01 * DEPTH + 2.0 * tolerance).all() and (ds.deepest > 0.9 * DEPTH).all()


@pytest.mark.filterwarnings("ignore:.*has lost energy:RuntimeWarning")
@pytest.mark.parametrize("name", ["average_acceleration", "central_difference", "rk4"])
def test_stops_on_both_sides_put_no_energy_in(name):
    """The depth of the stops, 0.003, is far below the error of u that the largest tolerance allows."""

    def energy(u, v):
        return v**2 / 2 + 5e5 * (jnp.maximum(u - 1, 0.0) ** 2 + jnp.minimum(u + 1, 0.0) ** 2)

    stops = study.Problem(lambda u: 1e6 * (jnp.maximum(u - 1, 0.0) + jnp.minimum(u + 1, 0.0)), u0=0.0, v0=3.0)
    observe = [study.Quantity(energy, name=reduce, reduce=reduce) for reduce in ("peak", "final")]
    ds = study.run(stops, name, tolerance=np.array([1e-2, 1e-4, 1e-6]), duration=10.0, observe=observe)
    assert (ds.status == 0).all() and (ds.peak < 1.05 * 4.5).all()
    assert (ds.final[1:] > 0.9 * 4.5).all() and ds.final[2] > 0.98 * 4.5


def test_controllers_that_accept_every_estimate_repeat_a_step_into_the_floor():
    sized = {"tolerance": 0.05, "duration": 2.0, "dt": 0.05, "observe": [SPECIFIC]}
    ds = study.run(FALL, "generalized_alpha", estimator="apparent_frequency", controller="nastran", **sized)
    assert ds.steps_rejected_by_solver > 0 and ds.energy < 3 * 2 * G


def test_stops_on_both_sides_of_one_unknown_of_several():
    """Two masses on a spring between two stops that is far stiffer; without damping the energy is constant."""

    def force(u):
        stop = 1e6 * (jnp.maximum(u[1] - 0.3, 0.0) + jnp.minimum(u[1] + 0.3, 0.0))
        return jnp.stack([4.0 * (u[0] - u[1]), 4.0 * (u[1] - u[0]) + stop])

    def potential(u):
        stop = 5e5 * (jnp.maximum(u[1] - 0.3, 0.0) ** 2 + jnp.minimum(u[1] + 0.3, 0.0) ** 2)
        return 2.0 * (u[0] - u[1]) ** 2 + stop

    stopped = study.Problem(force, [1.0, 0.0], potential=potential, mass=[1.0, 0.1])
    ds = study.run(stopped, "generalized_alpha", tolerance=1e-5, duration=5.0, observe=["energy_error", "trajectory"])
    assert ds.status == 0 and abs(ds.energy_error).max() < 0.02
    assert abs(ds.u[:, 1]).max() < 0.3 + np.sqrt(2 * 2.0 / 1e6) and abs(ds.u[:, 1]).max() > 0.3


@pytest.mark.slow
def test_a_smooth_motion_takes_the_steps_that_it_took(monkeypatch):
    """The numbers of steps are those of the estimate of Zienkiewicz and Xie alone, up to two percent."""
    duffing = study.Problem(lambda u: u + u**3, u0=1.0, v0=0.3, damping=0.1, load=lambda t: 0.5 * jnp.cos(1.3 * t))
    wanted = {"tolerance": [1e-4, 1e-6], "duration": 10.0, "observe": ["peak"]}
    ds = study.run(duffing, "generalized_alpha", **wanted)
    monkeypatch.setattr(control, "with_end", lambda estimator, *_: estimator)
    alone = study.run(duffing, "generalized_alpha", **wanted)
    np.testing.assert_allclose(ds.steps, alone.steps, rtol=0.02)
