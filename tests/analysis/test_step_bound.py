"""Step bounds from the modified energy."""

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

import study
from study.analysis.step_bound import step_bound
from study.observer.crossings import Oscillations

OSCILLATOR = study.Problem(potential=lambda u: 2 * u**2, u0=0.3, title="linear")
PENDULUM = study.Problem(potential=lambda u: 1 - jnp.cos(u), u0=2.5, title="pendulum")
MORSE = study.Problem(potential=lambda u: jnp.expm1(-u) ** 2, u0=-0.5, mass=1.7, title="Morse")
#: The force has a sign that changes, and its tangent does not jump there.
CUBE = study.Problem(potential=lambda u: jnp.abs(u) ** 3, u0=1.0, title="cube")
STOP = study.Problem(potential=lambda u: u**2 / 2 + 5 * jnp.maximum(u - 0.5, 0) ** 2, u0=1.0, title="stop")
#: Where such a contact closes, runs at the bound err by up to 1.8 times the allowed error of the energy.
HERTZ = study.Problem(potential=lambda u: jnp.maximum(u - 0.1, 0) ** 2.5 + u**2 / 2, u0=1.0, title="Hertz")
#: Forces that jump, or with an infinite tangent, without a switch that JAX shows.
SAW = study.Problem(potential=lambda u: jnp.sqrt(u * u), u0=1.0, title="saw")
TABLE = study.Problem(
    potential=lambda u: jnp.interp(u, jnp.linspace(-2, 2, 41), jnp.linspace(-2, 2, 41) ** 2), u0=1.05, title="table"
)
SINGULAR = study.Problem(potential=lambda u: jnp.abs(u) ** 1.5, u0=1.0, title="singular")
MOVING = study.Problem(potential=lambda u: jnp.exp(u) - u - 1, u0=0.2, v0=1.0, title="Toda")


@pytest.mark.parametrize(
    "scheme, energy, period",
    [
        ("central_difference", 1 / 4, 1 / 24),
        ("average_acceleration", 0, 1 / 12),
        ("implicit_midpoint", 0, 1 / 12),
        ("fox_goodwin", 1 / 6, 0),
    ],
)
def test_linear_theory(scheme, energy, period):
    """Energy and period of the linear oscillator, as the recurrences give them in closed form."""
    ds = step_bound(OSCILLATOR, scheme, allowed_error=0.01, periods=100)
    assert ds.highest_frequency == pytest.approx(2) and ds.period == pytest.approx(np.pi)
    phase = np.linspace(0, 2 * np.pi, 100_001)
    displacement = np.abs((198 * np.pi + phase) * np.sin(phase)).max() * period  # in the last period
    assert ds.coefficient.values == pytest.approx([energy, period, displacement], rel=1e-5, abs=1e-9)
    kept = ds.coefficient * ds.omega_step**2
    assert (kept <= 0.01 * (1 + 1e-12)).all() and (ds.omega_step <= 0.5).all()
    assert (ds.step_size * 2).values == pytest.approx(ds.omega_step.values)


@pytest.mark.slow
def test_a_potential_may_read_a_value_that_changes():
    """A compiled quadrature of the first stiffness is not used for the second."""
    stiffness = {"k": 1.0}
    problem = study.Problem(potential=lambda u: stiffness["k"] * u**2 / 2, u0=0.3, title="changing")
    for k in (1.0, 4.0):
        stiffness["k"] = k
        assert step_bound(problem, "central_difference").period == pytest.approx(2 * np.pi / np.sqrt(k))


@pytest.mark.slow
def test_the_period_of_the_pendulum():
    exact = 4 * mpmath.ellipk(mpmath.sin(1.25) ** 2)
    assert step_bound(PENDULUM, "central_difference").period == pytest.approx(float(exact), rel=1e-12)


@pytest.mark.parametrize("u0", [0.5, 0.9995, 0.9997, 0.9999, 0.99995])
def test_the_period_near_a_hill(u0):
    """The hills at ±1 lie between two places at which a turning point is sought."""
    problem = study.Problem(potential=lambda u: u**2 / 2 - u**4 / 4, u0=u0)
    exact = 4 * mpmath.ellipk(u0**2 / (2 - u0**2)) / mpmath.sqrt(1 - u0**2 / 2)
    assert step_bound(problem, "central_difference").period == pytest.approx(float(exact), rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("problem", [PENDULUM, MORSE, MOVING, CUBE], ids=lambda problem: problem.title)
@pytest.mark.parametrize("scheme", [study.schemes["central_difference"], study.Newmark(beta=0.2, gamma=0.5)])
def test_errors_of_runs_are_those_predicted(problem, scheme):
    """The leading terms are confirmed by runs whose steps are so small that the next terms are a hundredth."""
    ds = step_bound(problem, scheme, periods=20)
    dt = 0.1 / ds.highest_frequency.item()
    rest = study.OutcomeObserver.of(problem)
    run = study.run(
        problem,
        scheme,
        dt=dt,
        steps=int(20 * ds.period / dt),
        observe=["max_energy_error", Oscillations(rest.rest_at)],
    )
    initial = float(problem.energy(problem.u0, problem.v0))
    energy = run.max_energy_error * abs(initial) / (initial - rest.rest)
    period = abs(run.mean_period / ds.period - 1)
    assert [energy.item(), period.item()] == pytest.approx(0.01 * ds.coefficient.values[:2], rel=0.02)


@pytest.mark.parametrize("scheme", ["central_difference", "average_acceleration"])
def test_a_step_does_not_pass_over_the_bend_of_a_spring_that_saturates(scheme):
    """Only this test catches a step so long that terms of higher order count: without it the error is up to 3.5 %."""
    problem = study.Problem(potential=lambda u: jnp.logaddexp(u, -u) - jnp.log(2.0), u0=70.0, title="saturating")
    ds = step_bound(problem, scheme)
    u = np.linspace(-5, 5, 100_001)
    speed = np.sqrt(2 * (np.log(np.cosh(70.0)) - np.log(np.cosh(u))))
    change = np.abs(2 * np.tanh(u) / np.cosh(u) ** 2 * speed).max()
    assert ds.omega_step.sel(quantity="energy") == pytest.approx(0.5 / change, rel=0.01)
    step = ds.step_size.sel(quantity="energy").item()
    run = study.run(problem, scheme, dt=step, steps=int(50 * ds.period / step), observe=["max_energy_error"])
    predicted = ds.coefficient.sel(quantity="energy").item() * step**2
    assert run.max_energy_error.item() == pytest.approx(predicted, rel=0.05)


@pytest.mark.parametrize("scheme", ["central_difference", "average_acceleration"])
def test_a_step_does_not_pass_over_waves_of_the_tangent(scheme):
    """A spring with ripples: only this test catches steps of several waves, whose errors reach ten times the bound."""
    ripples = study.Problem(potential=lambda u: u**2 / 2 - 0.05 * jnp.cos(30 * u) / 900, u0=1.5, title="ripples")
    ds = step_bound(ripples, scheme).sel(quantity="energy")
    assert ds.omega_step == pytest.approx(1.6 / (30 * 1.5 * np.pi / 4), rel=0.05)  # the mean velocity is 1.5 π/4
    steps = ds.step_size.item() * np.linspace(0.5, 1.0, 30)
    numbers = np.ceil(100 * ds.period.item() / steps).astype(int)
    run = study.run(ripples, scheme, dt=steps, steps=numbers, observe=["max_energy_error"])
    predicted = ds.coefficient.item() * (ds.omega_step.item() * steps / steps[-1]) ** 2
    assert (run.max_energy_error.values < 1.1 * predicted).all()


@pytest.mark.parametrize("problem", [PENDULUM, MORSE], ids=lambda problem: problem.title)
def test_from_rest_average_acceleration_delays_twice_as_much_as_central_difference_advances(problem):
    central, average = (
        step_bound(problem, name).coefficient for name in ("central_difference", "average_acceleration")
    )
    assert (average / central).values[1:] == pytest.approx([2, 2], rel=1e-9)


def test_the_displacement_is_wrong_by_the_delay():
    """A reference with steps forty times as small; the error oscillates within a period by a hundredth of its end."""
    ds = step_bound(PENDULUM, "average_acceleration", allowed_error=0.01, periods=50)
    dt = ds.step_size.sel(quantity="displacement").item()
    steps = int(50 * ds.period / dt)
    coarse = study.run(PENDULUM, "average_acceleration", dt=dt, steps=steps).u
    fine = study.run(PENDULUM, "average_acceleration", dt=dt / 40, steps=40 * steps, every=40).u
    assert (abs(coarse.values - fine.values).max() / 2.5).item() == pytest.approx(0.01, rel=0.03)


@pytest.mark.parametrize("scheme", ["central_difference", "fox_goodwin", "implicit_midpoint"])
@pytest.mark.parametrize(
    "start, periods", [((1.151, 1.284), 100), ((1.0, 1.3), 10), ((0.5, 1.6), 1), ((np.pi / 2, 1.265), 100)]
)
def test_the_displacement_of_a_motion_that_begins_anywhere_keeps_the_error(scheme, start, periods):
    """Where the delays of the energy and of the period nearly cancel, the error of the shape and the next terms remain.

    Only this test catches a bound from the delay alone, or from the terms of Δt² alone near a separatrix; the errors
    are then up to four times the allowed one.
    """
    pendulum = study.Problem(jnp.sin, *start, potential=lambda u: 1 - jnp.cos(u))
    ds = step_bound(pendulum, scheme, 0.01, periods=periods)
    dt = ds.step_size.sel(quantity="displacement").item()
    steps = int(periods * ds.period / dt)
    u = study.run(pendulum, scheme, dt=dt, steps=steps).u.values
    exact = study.run(pendulum, "kahan_li8", dt=dt / 8, steps=8 * steps, every=8).u.values
    error = abs(u - exact).max() / abs(exact).max()
    assert error < 0.0105 and (error > 0.009 or scheme != "central_difference" or periods == 100)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness, width, frequency", [(30, 1e-2, 31**0.5), (30, 3e-4, 31**0.5), (1e4, 1e-6, None)])
def test_a_narrow_peak_of_the_tangent_is_resolved_or_refused(stiffness, width, frequency):
    def potential(u):
        s = (u - 0.3) / width
        peak = jnp.sqrt(jnp.pi) * s * jax.scipy.special.erf(s) + jnp.exp(-(s**2))
        return u**2 / 2 + stiffness * width**2 / 2 * peak

    spot = study.Problem(potential=potential, u0=1.0, title="spot")
    if frequency is None:
        with pytest.raises(ValueError, match="the tangent of 'spot' is not the slope of its force near u = 0.3"):
            step_bound(spot, "central_difference")
    else:
        omega = step_bound(spot, "central_difference").highest_frequency.item()
        assert omega == pytest.approx(frequency, rel=0.01)


def test_a_kink_of_the_tangent_is_no_wave():
    """It alone catches a step that depends on the number of points beside the kink."""
    ds = step_bound(CUBE, "central_difference").sel(quantity="energy")
    assert ds.omega_step == pytest.approx(np.sqrt(0.01 / ds.coefficient))


@pytest.mark.slow
@pytest.mark.parametrize("scheme, convex", [("central_difference", 1 / 4), ("average_acceleration", 1 / 6)])
def test_a_convex_chain_of_many_unknowns_keeps_the_bound_of_the_energy(scheme, convex):
    """A chain of hardening springs whose highest frequency grows with the amplitude."""

    def potential(u):
        strain = jnp.diff(u, prepend=0.0, append=0.0)
        return (strain**2 / 2 + strain**4).sum()

    start = jnp.array([1.0, 0.0, -0.5, 0.2, 0.8])
    chain = study.Problem(potential=potential, u0=start)
    fine = study.run(chain, "rk4", dt=0.002, steps=5000, every=10)
    tangents = jax.vmap(jax.hessian(potential))(fine.u.values.reshape(-1, 5))
    omega = np.sqrt(np.linalg.eigvalsh(tangents).max())
    run = study.run(chain, scheme, dt=0.15 / omega, steps=2000, observe=["max_energy_error"])
    error = run.max_energy_error.item()
    assert 0.2 * convex < error / 0.15**2 < convex
    assert step_bound(PENDULUM, scheme).convex_coefficient == pytest.approx(convex)


@pytest.mark.slow
@pytest.mark.parametrize(
    "potential, u0, distance",
    [
        (lambda u: 1 - jnp.cos(u), 2.5, 1 / np.tan(1.25) ** 2),
        (lambda u: u**4 / 4 - u**2 / 2, 1.4, 0.0196 / 0.2304),
        (lambda u: u**4 / 4 - u**2 / 2, 1.42, (1.42**4 / 4 - 1.42**2 / 2) / (1.42**4 / 4 - 1.42**2 / 2 + 0.25)),
        (lambda u: jnp.expm1(-u) ** 2, -0.5, 1 / np.expm1(0.5) ** 2 - 1),
        (lambda u: jnp.logaddexp(u, -u), 3.0, np.inf),
        (lambda u: u**2 / 2 + 1 / u, 2.0, np.inf),
    ],
    ids=["pendulum", "in one well", "over both wells", "limit far away", "none", "wall"],
)
def test_the_distance_to_a_separatrix(potential, u0, distance):
    bound = step_bound(study.Problem(potential=potential, u0=u0), "central_difference")
    assert bound.separatrix_distance.item() == pytest.approx(distance, rel=1e-9)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ((PENDULUM, "rk4"), "the error of 'Runge-Kutta.*is not known without a run"),
        ((PENDULUM, study.Newmark(beta=0.3025, gamma=0.6)), "with gamma = 0.5"),
        ((PENDULUM, "central_difference", -0.01), "error must be a positive number, not -0.01"),
        ((PENDULUM, "central_difference", "1%"), "error must be a positive number, not '1%'"),
        (
            (study.Problem(potential=lambda u: 1 - jnp.cos(u), u0=np.pi), "central_difference"),
            "too near to a separatrix",
        ),
        (
            (study.Problem(potential=lambda u: (u - 1000) ** 2 / 2, u0=1000.0, v0=1e-3), "central_difference"),
            "so small against its displacement or its potential that round-off hides it",
        ),
        ((PENDULUM, "central_difference", 0.01, 0), "periods must be a positive number, not 0"),
        ((study.Problem(potential=lambda u: u**2, u0=0.0, title="own"), "central_difference"), "'own' rests"),
        (
            (study.Problem(potential=lambda u: 1 - jnp.cos(u), u0=0.0, v0=2.1, title="own"), "central_difference"),
            "'own' does not oscillate",
        ),
        ((STOP, "central_difference"), "its tangent jumps at u = 0.5"),
        ((study.Problem(potential=jnp.abs, u0=1.0, title="own"), "central_difference"), "jumps at u = 0"),
        ((SAW, "central_difference"), "the tangent of 'saw' is not the slope of its force near u = "),
        ((TABLE, "central_difference"), "the tangent of 'table' is not the slope of its force near u = "),
        ((SINGULAR, "central_difference"), "the tangent of 'singular' (is not the slope|has an infinite slope)"),
        ((HERTZ, "central_difference"), "the tangent of 'Hertz' has an infinite slope at u = 0.1"),
        (("fpu_chain", "central_difference"), "more than one unknown"),
        (("duffing_chaotic", "central_difference"), "damping or a load"),
    ],
)
def test_what_has_no_bound(arguments, sentence):
    """A motion or scheme without a modified energy that is given a step, not a sentence."""
    with pytest.raises(ValueError, match=sentence):
        step_bound(*arguments)
