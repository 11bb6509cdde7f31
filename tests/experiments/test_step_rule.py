"""Errors against the product of the step size and the highest frequency of the motion."""

import numpy as np
import pytest

import study
from study.experiments.step_rule import step_rule


def test_errors_are_those_of_a_run(springs):
    ds = step_rule(["central_difference"], {"first": -0.8, "last": 0.5, "count": 2}, 10)
    errors = ds.isel(scheme=0, omega_step=0).sel(problem="hardening").isel(amplitude=2)
    exact = springs.sel(problem="hardening").isel(amplitude=2)
    dt = (10**-0.8 / exact.highest_frequency).item()
    run = study.run(
        "hardening",
        "central_difference",
        dt=dt,
        steps=int(np.ceil(10 * exact.period / dt)),
        u0=exact.u0.item(),
        observe=["max_energy_error", "oscillations"],
    )
    assert errors.max_energy_error.item() == pytest.approx(run.max_energy_error.item(), rel=1e-9)
    assert errors.period_error.item() == pytest.approx(abs(run.mean_period.item() / exact.period.item() - 1), rel=1e-9)
    assert ds.max_energy_error.isel(omega_step=1).isnull().any()  # beyond the stability limit of two


@pytest.mark.slow
def test_the_energy_of_a_well_is_measured_from_its_bottom(springs):
    ds = step_rule(["rk4"], {"first": -1, "last": -0.5, "count": 2}, 10).sel(problem="double_well").isel(scheme=0)
    # the energy error is of fifth order, so that a step size √10 times as large makes it some 300 times as large
    assert ((ds.max_energy_error[:, 1] / ds.max_energy_error[:, 0]) > 100).all()
    assert (ds.max_energy_error[:, 0] < 1e-2).all()
