"""Tolerances that keep an error, and the cost of runs with step size control."""

import numpy as np
import pandas as pd
import pytest

import study
from reference import taylor
from study.assessment.report import page
from study.assessment.search import COARSEST_KEEPS, FOUND, STARTS, Case
from study.assessment.tolerances import EQUAL_ONLY, ToleranceSearch, round_tolerance

DURATION, ALLOWED = 20.0, 0.01


@pytest.fixture(scope="module")
def duffing():
    return study.Problem(lambda u: u + u**3, potential=lambda u: u**2 / 2 + u**4 / 4, u0=1.0, title="Duffing")


@pytest.fixture(scope="module")
def assessed(duffing):
    schemes = ["average_acceleration", "dormand_prince6", "houbolt"]
    return study.assess(duffing, schemes, duration=DURATION, allowed_errors=[ALLOWED], maps=False, controller="pi")


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "dormand_prince6"])
def test_fresh_tolerances_below_the_recommended_one_keep_the_error(duffing, assessed, scheme):
    """Errors refer to heyoka's trajectory at the times of each run, not to the assessment's interpolated reference."""
    row = assessed.sel(scheme=scheme, quantity="displacement", allowed_error=ALLOWED)
    assert row.tolerance_verdict == FOUND and row.tolerances_tried > 32 and row.tolerance_largest_error <= ALLOWED
    rng = np.random.default_rng(7)
    for tolerance in row.tolerance.item() * 10 ** -np.append(0.0, 2 * rng.random(9)):
        ds = study.run(duffing, scheme, tolerance=tolerance, duration=DURATION)
        exact = taylor.trajectory(duffing, ds.t.values[1:], 1e-14).u
        assert np.abs(ds.u.values[1:] - exact).max() <= 1.001 * ALLOWED
        assert ds.t[-1] == DURATION


def test_a_scheme_that_keeps_the_error_at_all_tolerances_has_the_loosest(duffing, monkeypatch):
    """Only this test catches a largest tolerance that is not one of those tried, but a power of a root of it."""

    def made_up(self, start, tolerance):
        return pd.DataFrame({"start": start, "tolerance": tolerance, "u": 1e-6, "steps": 10, "forces": 10})

    monkeypatch.setattr(ToleranceSearch, "_run", made_up)
    for name in ("average_acceleration", "dormand_prince6"):
        cases = dict.fromkeys((1.0, *STARTS), Case(duffing, {}, None))
        search = ToleranceSearch(study.schemes[name], study.controllers["pi"], cases, DURATION, False)
        search.search([("u", 0.01)], lambda top: None)
        assert search.verdict("u", 0.01).how == COARSEST_KEEPS


def test_ten_times_the_tolerance_does_not_keep_the_error(duffing, assessed):
    tolerance = 10 * assessed.tolerance.sel(scheme="average_acceleration", quantity="displacement").item()
    ds = study.run(duffing, "average_acceleration", tolerance=tolerance, duration=DURATION)
    assert np.abs(ds.u.values[1:] - taylor.trajectory(duffing, ds.t.values[1:], 1e-14).u).max() > ALLOWED


def test_the_cost_is_that_of_the_run_with_this_tolerance(duffing, assessed):
    row = assessed.sel(scheme="dormand_prince6", quantity="displacement", allowed_error=ALLOWED)
    ds = study.run(duffing, "dormand_prince6", tolerance=row.tolerance.item(), duration=DURATION)
    assert row.controlled_steps == ds.steps
    trials = ds.steps + ds.steps_rejected_by_estimate
    effort = study.run(duffing, "dormand_prince6", tolerance=ds.tolerance, duration=DURATION, observe="effort")
    assert row.controlled_force_evaluations == effort.force_evaluations > 5 * trials


def test_what_needs_equal_steps_has_no_tolerance(assessed):
    houbolt = assessed.sel(scheme="houbolt")
    periods = assessed.sel(quantity=["period", "phase", "amplitude"])
    for part in (houbolt, periods):
        assert (part.tolerance_verdict == EQUAL_ONLY).all() and part.tolerance.isnull().all()


def test_recommend_states_whether_equal_steps_are_cheaper(assessed):
    table = study.recommend(assessed, allowed_error=ALLOWED, quantity="displacement")
    ratio = table.controlled_force_evaluations / table.force_evaluations
    np.testing.assert_array_equal(table.control_over_equal, ratio)
    assert np.isnan(table.tolerance["houbolt"]) and table.tolerance["average_acceleration"] > 0


def test_the_report_lists_the_tolerances(assessed, undrawn):
    text = page(assessed)
    assert text.count("controlled steps, PI (× forces of equal steps)</th>") == assessed.sizes["quantity"]
    quantities_with_tolerance = ("displacement", "velocity", "acceleration", "energy")
    assert text.count("<th>controlled steps</th>") == len(quantities_with_tolerance)


def test_your_own_quantity_may_have_the_name_of_a_default_one(duffing):
    """A quantity that replaces the default one of the same name in controlled runs."""
    quantities = {"amplitude": study.Quantity(lambda u: u, reduce="peak")}
    options = {"duration": 10.0, "allowed_errors": [0.1], "maps": False, "controller": "pi"}
    ds = study.assess(duffing, "average_acceleration", quantities=quantities, **options)
    assert (ds.tolerance_verdict <= COARSEST_KEEPS).all() and (ds.tolerance > 0).all()


@pytest.mark.parametrize("largest, expected", [(0.1, 0.1), (0.0999, 0.05), (3e-4, 2e-4), (5e-7, 5e-7), (1.01e-3, 1e-3)])
def test_a_tolerance_is_one_two_or_five_times_a_power_of_ten(largest, expected):
    assert round_tolerance(largest) == expected


def test_programs_and_large_models_have_no_tolerances():
    large = study.Problem(lambda u: u, u0=np.ones(1001), stiffness=None, title="large")
    with pytest.raises(ValueError, match="up to 1,000 unknowns"):
        study.assess(large, ["rk4"], duration=1.0, controller="pi")
    program = study.Program(lambda scheme, dt: {"t": [0.0, 1.0], "u": [1.0, 1.0]}, schemes=["a", "b"], duration=1.0)
    with pytest.raises(ValueError, match="leave quantities, duration and controller out"):
        study.assess(program, controller="pi")


@pytest.mark.slow
def test_an_unknown_controller_is_named(duffing):
    with pytest.raises(KeyError, match="controller"):
        study.assess(duffing, ["rk4"], duration=1.0, controller="pid")
