"""Energy errors and the balance of energy."""

import jax.numpy as jnp
import numpy as np
import pytest

import study

N, DT, STEPS = 5, 0.05, 20


def _balance(problem, scheme, dt, steps, **arguments):
    ds = study.run(problem, scheme, dt=dt, steps=steps, observe=["energy_balance"], **arguments)
    assert (ds.status == 0).all()
    return ds


@pytest.mark.slow
def test_the_trapezoidal_rule_balances_a_linear_structure_to_round_off(damped_chain):
    problem = damped_chain(linear=True)
    ds = _balance(problem, "average_acceleration", dt=0.2, steps=200)
    assert ds.max_energy_imbalance < 1e-13
    assert ds.dissipated_energy > 0.1 and abs(ds.work_of_load) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "implicit_midpoint", "energy_momentum", "rk4", "gauss4"])
def test_the_balance_closes_with_the_second_order(damped_chain, scheme):
    problem = damped_chain("tridiagonal")
    errors = [_balance(problem, scheme, 4 / n, n).max_energy_imbalance.item() for n in (100, 200, 400)]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2, abs=0.1)


def test_what_a_force_without_a_potential_dissipates_the_kinetic_energy_loses():
    problem = study.Problem(lambda u, v: 9 * u + 0.5 * v, 1.0, 2.0, mass=2.0)
    ds = _balance(problem, "average_acceleration", dt=0.1, steps=200)
    assert ds.max_energy_imbalance < 1e-13
    end = study.run(problem, "average_acceleration", dt=0.1, steps=200).isel(t=-1)
    assert ds.dissipated_energy.item() == pytest.approx(2.0**2 - end.v.item() ** 2, rel=1e-11)


def test_a_problem_at_rest_is_in_balance():
    ds = _balance(study.Problem(potential=lambda u: u @ u, u0=np.zeros(3)), "average_acceleration", DT, STEPS)
    assert ds.max_energy_imbalance == 0


def test_a_blow_up_is_no_loss():
    """Without a load, the imbalance is relative to the initial energy; after a blow-up it exceeds 100."""
    stiff = study.Problem(lambda u: 100 * u, 1.0, potential=lambda u: 50 * u * u)
    with pytest.warns(RuntimeWarning, match="exceeds 2, the stability limit"):
        ds = _balance(stiff, "central_difference", 0.25, 20, bound=np.inf)
    assert ds.max_energy_imbalance > 1e2


def test_an_oscillator_dissipates_all_that_it_had():
    problem = study.Problem(lambda u: 9 * u, 0.5, 2.0, potential=lambda u: 4.5 * u * u, mass=2.0, damping=1.2)
    ds = _balance(problem, "average_acceleration", dt=0.02, steps=5000)
    assert ds.dissipated_energy.item() == pytest.approx(4.5 * 0.25 + 4, rel=1e-10)
    assert ds.work_of_load == 0


def test_half_of_the_work_of_a_load_that_stays_is_dissipated():
    """The load does the work f²/k; half of it stays in the spring, and half is dissipated."""
    problem = study.Problem(
        lambda u: 9 * u, 0.0, potential=lambda u: 4.5 * u * u, mass=2.0, damping=1.2, load=lambda t: jnp.asarray(3.0)
    )
    ds = _balance(problem, "average_acceleration", dt=0.02, steps=5000)
    assert ds.work_of_load.item() == pytest.approx(1, rel=1e-10)
    assert ds.dissipated_energy.item() == pytest.approx(0.5, rel=1e-10)


def test_lanes_balance_as_single_runs(damped_chain):
    problem, starts = damped_chain("tridiagonal"), np.linspace(0.2, 1, N) * np.array([[0.5], [1.0], [1.5]])
    lanes = _balance(problem, "average_acceleration", DT, STEPS, u0=starts)
    assert lanes.dissipated_energy.dims == ("lane",)
    for lane, u0 in enumerate(starts):
        alone = _balance(problem, "average_acceleration", DT, STEPS, u0=u0)
        for name in ("max_energy_imbalance", "dissipated_energy", "work_of_load"):
            assert lanes[name][lane].item() == pytest.approx(alone[name].item(), rel=1e-9)


@pytest.mark.slow
def test_the_mean_of_the_energy_error_is_that_of_the_samples(state_kind):
    ds = study.run("hardening", state_kind, dt=0.0075, steps=200, observe=["energy_error", "mean_energy_error"])
    assert ds.mean_energy_error.item() == pytest.approx(ds.energy_error[1:].mean().item(), rel=1e-9, abs=1e-14)
