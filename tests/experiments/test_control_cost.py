"""Force evaluations and errors of controlled and equal steps, and of general solvers."""

import numpy as np
import pytest
import xarray as xr

from reference.experiments.inelastic import inelastic
from reference.experiments.solver_cost import solver_cost
from study import io
from study.experiments.control_cost import NOT_RUN, control_cost
from study.experiments.control_of_codes import control_of_codes
from study.sizes import fewest


@pytest.fixture(scope="module")
def reference():
    return inelastic(["bouncing", "hysteretic"], 2, 8)


def _check_forces(controlled: xr.Dataset, forces_per_step: int) -> None:
    """A trial step evaluates ``forces_per_step`` forces, the start two; the run that measures the sizes is left out."""
    rest = controlled.force_evaluations - forces_per_step * (controlled.steps + controlled.rejected)
    assert (rest == 2).all()


@pytest.mark.slow
def test_control_reaches_the_exact_motion_of_a_bouncing_mass(reference, monkeypatch):
    """It alone compares controlled with equal steps, and counts the forces of an embedded pair."""
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    schemes = ["dormand_prince6", "houbolt"]
    ds = control_cost(["bouncing"], schemes, "pi", [1e-2, 1e-4, 1e-6], [8, 16, 32]).squeeze("problem")
    controlled, multistep = (ds.sel(scheme=name) for name in schemes)
    assert (controlled.status == 0).all() and controlled.sampled_error[-1] < 1e-4 < controlled.sampled_error[0]
    # each step, accepted or rejected, takes five force evaluations for six stages, because the first stage is known
    # the start takes one more, and the estimate evaluates the force at the end of a step, because its slope may jump
    _check_forces(controlled, 5 + 1)
    np.testing.assert_array_equal(controlled.equal_force_evaluations, 1 + 5 * 16 * ds.steps_per_sample)
    assert (controlled.equal_sampled_error.diff("steps_per_sample") < 0).all()
    assert (multistep.status == NOT_RUN).all() and np.isfinite(multistep.equal_sampled_error).all()
    needed = fewest(controlled.sampled_error, controlled.force_evaluations, 1e-3, "tolerance")
    assert needed < fewest(controlled.equal_sampled_error, controlled.equal_force_evaluations, 1e-3, "steps_per_sample")


def test_a_force_with_a_history_counts_what_commits_it(reference, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    ds = control_cost(["hysteretic"], ["rk4"], "pi", [1e-2, 1e-4], [16, 64]).squeeze()
    assert (ds.sampled_error < [0.1, 1e-2]).all() and (ds.equal_sampled_error < [0.1, 1e-2]).all()
    # four forces and one that commits the history, which the start does too
    np.testing.assert_array_equal(ds.equal_force_evaluations, 1 + 5 * 16 * ds.steps_per_sample)
    # step doubling takes three steps, and the estimate the force at the end
    _check_forces(ds, 3 * 5 + 1)


def test_solvers_have_no_force_with_a_history(reference, monkeypatch):
    monkeypatch.setattr(io, "open_dataset", lambda name: reference)
    ds = solver_cost(["bouncing", "hysteretic"], ["cvode_adams"], [1e-4, 1e-8]).squeeze("solver")
    assert (ds.sampled_error.sel(problem="bouncing") < [1e-1, 1e-4]).all() and ds.sampled_error.sel(
        problem="hysteretic"
    ).isnull().all()


def test_rules_of_codes_on_the_hardening_spring(monkeypatch):
    """It alone runs the rules of Nastran, Abaqus and OrdinaryDiffEqNewmark as an experiment."""
    period = 0.151532834447260357
    monkeypatch.setattr(io, "open_dataset", lambda name: xr.Dataset({"period": period}))
    ds = control_of_codes(["hardening"], [20], 10).squeeze()
    steps = ds.steps_per_period
    # Nastran aims at 40, 20 or 10 steps in the apparent period, and changes the step size by factors of two only
    assert (steps.sel(code="Nastran") > [20, 10, 5]).all() and (steps.sel(code="Nastran") < [80, 40, 20]).all()
    assert (steps.sel(code="Abaqus").diff("class") < 0).all() and steps.sel(code="Abaqus").max() < 20
    assert ds.halved_energy_error == pytest.approx(1, abs=0.01)
    # the tests of SciML's package OrdinaryDiffEqNewmark require a ratio of error to tolerance between 0.2 and 3
    assert (ds.error_in_tolerances > 0.2).all() and (ds.error_in_tolerances < 3).all()
