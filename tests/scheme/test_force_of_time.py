"""Forces that take the time: K(t), evaluated at the time of the load in every scheme."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import study
from reference import diffrax, sundials
from study.building import balance
from study.materials import elastoplastic
from study.problem import oscillators

DURATION = 4.0


def _stiffness(t, cos=jnp.cos):
    return 1.1 + 0.8 * cos(2 * t)


def _push(t):
    return jnp.sin(3 * t + 0.4)


@pytest.fixture(scope="module")
def excited():
    return study.Problem(lambda u, t: _stiffness(t) * u + 0.3 * u**3, 1.0, 0.3, title="excited")


@pytest.fixture(scope="module")
def exact():
    def rate(t, y):
        return y[1], -(_stiffness(t, np.cos) * y[0] + 0.3 * y[0] ** 3)

    return solve_ivp(rate, (0, DURATION), [1.0, 0.3], rtol=1e-13, atol=1e-13, method="DOP853").y[:, -1]


@pytest.mark.slow
def test_schemes_have_their_order_on_a_parametric_excitation(kind, excited, exact):
    scheme = study.schemes[kind]
    if kind == "energy_momentum":
        pytest.skip("it needs a potential")
    steps = np.array([4, 8] if scheme.order > 4 else [40, 80])
    end = study.Quantity(lambda u, v: jnp.stack([u, v]), name="end", reduce="final")
    ds = study.run(excited, scheme, dt=DURATION / steps, steps=steps, observe=[end])
    coarse, fine = np.abs(ds.end.values - exact).max(axis=1)
    assert np.log2(coarse / fine) > scheme.order_with_damping - 0.35


def _moved(force, load, **options):
    """The same equation twice: with a push as a load, and with the push in the force."""
    by_load = study.Problem(force, 1.0, 0.3, load=load, **options)
    return by_load, study.Problem(lambda u, t: force(u) - _push(t), 1.0, 0.3, **options)


@pytest.mark.slow
def test_a_push_in_the_force_acts_as_a_push_in_the_load(sampled_scheme):
    """The α-method of 1996 weights the force and not the load; its load must then have the weights of the force."""
    dt, alpha = 0.1, -0.1
    load = _push
    if sampled_scheme == "hht_alpha_1996":
        load = lambda t: jnp.where(t > 0, (1 + alpha) * _push(t) - alpha * _push(t - dt), _push(t))  # noqa: E731
    if sampled_scheme == "energy_momentum":
        pytest.skip("it needs a potential")
    by_load, by_force = _moved(lambda u: u + 0.3 * u**3, load)
    options = {"scheme": sampled_scheme, "dt": dt, "steps": 8}
    expected, observed = (study.run(problem, **options) for problem in (by_load, by_force))
    np.testing.assert_allclose(observed.u, expected.u, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(observed.v, expected.v, rtol=1e-11, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["bathe", "noh_bathe", "gauss4", "central_difference"])
def test_a_force_may_take_velocity_history_and_time(scheme):
    spring = elastoplastic(stiffness=1.0, yield_force=0.4)

    def pushed(u, v, history, time):
        force, history = spring(u, v, history)
        return force - _push(time), history

    by_load = study.Problem(spring, 0.0, 1.0, load=_push, damping=0.1)
    by_force = study.Problem(pushed, 0.0, 1.0, history=spring.history, damping=0.1)
    expected, observed = (study.run(problem, scheme, dt=0.1, steps=30) for problem in (by_load, by_force))
    np.testing.assert_allclose(observed.u, expected.u, rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("estimator", ["zienkiewicz_xie_balance", "three_point", "half_step_residual", "step_doubling"])
def test_controlled_steps_take_the_force_at_the_time_of_the_load(estimator):
    by_load, by_force = _moved(lambda u: u + 0.3 * u**3, _push)
    options = {"scheme": "average_acceleration", "tolerance": 1e-2, "duration": 5.0, "estimator": estimator}
    expected, observed = (study.run(problem, **options) for problem in (by_load, by_force))
    np.testing.assert_allclose(observed.step_size, expected.step_size, rtol=1e-8)
    np.testing.assert_allclose(observed.u, expected.u, rtol=1e-8)


@pytest.mark.slow
def test_references_solve_a_parametric_excitation(excited, exact):
    """A solver of references that leaves the time out of the internal force."""
    t = np.array([DURATION / 2, DURATION])
    for reference in (diffrax.trajectory(excited, t, 1e-12), sundials.trajectory(excited, t, 1e-12)):
        np.testing.assert_allclose([reference.u[-1], reference.v[-1]], exact, rtol=1e-9)


def test_a_switch_in_time_is_a_kink_of_the_reference():
    clutch = study.Problem(lambda u, t: jnp.where(t < 1.3, 1.0, 4.0) * u, 1.0)
    np.testing.assert_allclose(sundials.kinks(clutch, 3.0, np.zeros(0)), [1.3], atol=1e-9)


def test_the_coupling_of_unknowns_is_found_at_other_times_too():
    """At t = 0 no unknown is coupled."""
    coupling = np.array([[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]])
    problem = study.Problem(lambda u, t: u + jnp.sin(2 * t) * (coupling @ u), [1.0, 0.0, 0.0])
    assert problem.tangent == "dense"


@pytest.mark.slow
def test_pure_runs_and_ensembles_take_the_time():
    mathieu = oscillators.mathieu
    options = {"dt": 0.05, "steps": 100}
    ends = [study.final_state(mathieu(delta), "average_acceleration", **options)["u"] for delta in (1.5, 2.0)]
    ds = study.run(mathieu, "average_acceleration", over={"delta": np.array([1.5, 2.0])}, **options)
    np.testing.assert_allclose(ds.u.isel(t=-1), ends, rtol=1e-9)


def test_the_balance_of_energies_takes_the_work_of_the_force(excited):
    """The trapezoidal rule keeps this balance to round-off."""
    ds = study.run(excited, "average_acceleration", dt=0.1, steps=40, observe=["energy_balance", "internal_force"])
    assert ds.max_energy_imbalance < 1e-12
    first_force = ds.internal_force.values[0]
    assert first_force == pytest.approx(1.9 + 0.3)


def test_a_scheme_cannot_forget_the_time(excited):
    class Forgetful(study.Newmark):
        def increment(self, problem, state, t, dt):
            return balance(problem, 0.0, state.u, state.v, dt**2, dt, state.a)

    with pytest.raises(TypeError, match=r"increment of Forgetful raises .*the time, which problem.at_time\(t\) must"):
        study.run(excited, Forgetful(beta=0.25, gamma=0.5), dt=0.1, steps=2)


def test_what_cannot_take_the_time_is_refused(excited):
    for scheme in (study.EnergyMomentum(), study.AuxiliaryVariable(), study.Relaxed(scheme=study.schemes["rk4"])):
        assert "'excited'" in scheme.refusal(excited)
    with pytest.raises(ValueError, match="potential of 'moving' that depends on the time is not supported"):
        study.Problem(lambda u, t: t * u, 1.0, potential=lambda u, t: t * u**2 / 2, title="moving")
    with pytest.raises(ValueError, match="gives 't' a default, and would never be called with another value"):
        study.Problem(lambda u, t=0.0: t * u, 1.0)
    with pytest.raises(ValueError, match="finds no period of 'excited'"):
        diffrax.period(excited, 6.0)
