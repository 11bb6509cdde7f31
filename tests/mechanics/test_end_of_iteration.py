"""The end of Newton's iteration where rows know their unknowns to different accuracies."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

import study

#: Stiffness of two springs of 100 and 300 whose masses of 1 and 2 a multiplier ties to each other.
TIED = np.array([[100.0, 0.0, 1.0], [0.0, 300.0, -1.0], [1.0, -1.0, 0.0]])


def _tied(u):
    return jnp.asarray(TIED, u.dtype) @ u


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("scheme", ["bathe", "generalized_alpha"])
def test_masses_tied_by_a_multiplier_move_as_one_at_every_step_size(scheme, precision):
    """The tied masses oscillate with ω² = 400/3. The multiplier's round-off grows with 1/Δt²."""
    start = {"u0": np.array([1.0, 1.0, 100 / 3]), "mass": np.array([1.0, 2.0, 0.0])}
    problem, omega = study.Problem(_tied, tangent="dense", **start), np.sqrt(400 / 3)
    dt = np.array([0.1, 0.02, 5e-3, 1e-3, 1e-4, 1e-5])
    with jax.enable_x64(precision == "double"):
        ds = study.run(problem, scheme, dt=dt, steps=300, every=300, on_failure="raise")
    t = 300 * dt
    round_off = 1e-9 if precision == "double" else 1e-3
    for unknown in (0, 1):
        errors = np.abs(ds.u.values[:, -1, unknown] - np.cos(omega * t))
        assert np.all(errors <= 0.2 * omega**3 * t * dt**2 + round_off)


#: Gravity.
G = 9.81


def _hanging(form, angle):
    """A rigid pendulum of unit mass and length: its position or displacement, and the multiplier of its rod."""
    x0, y0 = np.sin(angle), -np.cos(angle)

    def force(u):
        x, y = (u[0], u[1]) if form == "position" else (u[0] + x0, u[1] + y0)
        length = jnp.sqrt(x * x + y * y)
        return jnp.stack([u[2] * x / length, u[2] * y / length + G, length - 1])

    position = [x0, y0] if form == "position" else [0.0, 0.0]
    u0 = np.array([*position, G * np.cos(angle)])
    return study.Problem(force, u0, mass=np.array([1.0, 1.0, 0.0]), tangent="dense")


@pytest.mark.slow
@pytest.mark.parametrize("form, angle", [("position", 1.0), ("displacement", 1.0), ("displacement", 1e-3)])
@pytest.mark.parametrize("scheme", ["bathe", "tr_bdf2", "bdf2", "generalized_alpha"])
def test_a_rigid_pendulum_swings_as_the_elliptic_function_at_every_step_size(scheme, form, angle):
    """sin(θ/2) = k cd(√g t, k), and the rod carries the force 3 g cos θ − 2 g cos θ₀, found to first order."""
    dt = np.array([0.05, 0.01, 1e-3, 1e-4, 1e-6])
    ds = study.run(_hanging(form, angle), scheme, dt=dt, steps=100, every=100, on_failure="raise")
    t, m = 100 * dt, np.sin(angle / 2) ** 2
    sine, *_ = ellipj(np.sqrt(G) * t + ellipk(m), m)
    theta = 2 * np.arcsin(np.sin(angle / 2) * sine)
    x, y, force = ds.u.values[:, -1].T
    if form == "displacement":
        x, y = x + np.sin(angle), y - np.cos(angle)
    np.testing.assert_array_less(np.abs(x - np.sin(theta)), angle * (20 * dt**2 * (1 + t) + 1e-9))
    known = 1e-13 / dt**2
    np.testing.assert_array_less(np.abs(force - 3 * G * np.cos(theta) + 2 * G * np.cos(angle)), 50 * dt + known)


def _in_series(u):
    joint = u[1]
    near, far = 100 * joint + 400 * joint**3, 50 * (u[0] - joint)
    return jnp.stack([far, near - far])


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe"])
def test_a_joint_without_mass_between_two_springs(scheme):
    """The joint is condensed by bisection, and SciPy integrates the remaining equation."""

    def joint(u):
        return brentq(lambda x: 100 * x + 400 * x**3 - 50 * (u - x), -10, 10, xtol=1e-15)

    def rates(t, y):
        return [y[1], -50 * (y[0] - joint(y[0]))]

    dt = np.array([0.02, 1e-3, 1e-5])
    problem = study.Problem(_in_series, np.array([1.0, joint(1.0)]), mass=np.array([1.0, 0.0]))
    ds = study.run(problem, scheme, dt=dt, steps=50, every=50, on_failure="raise")
    exact = solve_ivp(rates, (0, 1.0), [1.0, 0.0], t_eval=np.sort(50 * dt), rtol=1e-11, atol=1e-12).y[0][::-1]
    np.testing.assert_array_less(np.abs(ds.u.values[:, -1, 0] - exact), 30 * dt**2 + 1e-11)
    np.testing.assert_allclose(ds.u.values[:, -1, 1], [joint(u) for u in ds.u.values[:, -1, 0]], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe"])
def test_a_stiff_bar_is_in_balance_up_to_the_round_off_of_its_elongation(scheme):
    """A bar of stiffness 10¹⁰ falls about its hinge. Its elongation is about the round-off of its length."""

    def force(u):
        x, y = 1 + u[0], u[1]
        length = jnp.sqrt(x * x + y * y)
        return 1e10 * (length - 1) / length * jnp.stack([x, y])

    dt = np.array([1e-2, 1e-3, 1e-4, 1e-5])
    bar = study.Problem(force, np.zeros(2), load=lambda t: jnp.array([0.0, -G]))
    ds = study.run(bar, scheme, dt=dt, steps=50, every=50, on_failure="raise")
    # a pendulum that is released from the horizontal
    sine, *_ = ellipj(np.sqrt(G) * 50 * dt + ellipk(0.5), 0.5)
    theta = 2 * np.arcsin(np.sqrt(0.5) * sine)
    np.testing.assert_allclose(ds.u.values[:, -1, 1], -np.cos(theta), rtol=5e-3)


#: Units of displacement and rotation, and of force and moment, relative to m, rad, N and N m.
UNITS = {"SI": (1.0, 1.0, 1.0, 1.0), "mm and kN": (1e-3, 1.0, 1e3, 1e3), "mm and N mm": (1e-3, 1.0, 1.0, 1e-3)}


def _cantilever(units, massless):
    """A cantilever whose tip moves and turns, with a stiffening spring at the tip; u in the given units."""
    length, angle, force, moment = UNITS[units]
    u_unit, p_unit = np.array([length, angle]), np.array([force, moment])
    stiffness = np.array([[12e4, -6e4], [-6e4, 4e4]])

    def internal(u):
        si = u * u_unit
        return (stiffness @ si + jnp.stack([1e7 * si[0] ** 3, 1e6 * si[1] ** 3])) / p_unit

    mass = np.array([10.0, 0.0 if massless else 0.02]) * u_unit / p_unit
    u0 = np.array([0.05, 0.0])
    u0[1] = brentq(lambda r: -6e4 * 0.05 + 4e4 * r + 1e6 * r**3, -1, 1, xtol=1e-15)
    return study.Problem(internal, u0 / u_unit, mass=mass, tangent="dense"), u_unit


@pytest.mark.slow
@pytest.mark.parametrize("massless", [False, True])
def test_units_do_not_change_the_motion(massless):
    displacements = []
    for units in UNITS:
        problem, u_unit = _cantilever(units, massless)
        ds = study.run(problem, "bathe", dt=[1e-2, 1e-4], steps=50, on_failure="raise")
        displacements.append(ds.u.values * u_unit)
    peaks = np.abs(displacements[0]).max(axis=1)
    for displacement in displacements[1:]:
        np.testing.assert_array_less(np.abs(displacement - displacements[0]).max(axis=1) / peaks, 1e-10)


def test_smaller_steps_are_no_advice_where_they_do_not_help():
    """No displacement satisfies u² + 1 = 0 at any step size."""
    impossible = study.Problem(
        lambda u: jnp.stack([u[0], u[1] ** 2 + 1.0]), np.ones(2), mass=np.array([1.0, 0.0]), tangent="dense"
    )
    with pytest.raises(RuntimeError, match="unknown without mass has no root") as failure:
        study.run(impossible, "bathe", dt=1e-3, steps=2, on_failure="raise")
    assert "smaller steps" not in str(failure.value)
