"""Claims of the conclusions on made-up datasets, at both sides of the bounds of their checks."""

import pytest
import xarray as xr

from paper.claims import comparisons, conclusions
from paper.claims.ledger import Verdict
from paper.published import SCHEMES
from tests.paper.claims.made_up import energy_error, filled

PARTS = [0.01, 0.04, 0.05]


def _large_steps(**worst):
    """A dataset like large_steps.nc, with errors of 99 %.

    Faithful schemes have 1 % below T/20, except central difference at 0.04 T; ``worst`` gives this error by problem.
    """
    schemes = ["average_acceleration", "central_difference", "houbolt"]
    dims = ["problem", "scheme", "step_size_over_period"]
    error = xr.DataArray(99.0, dict(zip(dims, (list(worst), schemes, PARTS), strict=True)), dims).copy()
    for problem, value in worst.items():
        faithful = {"problem": problem, "scheme": ["average_acceleration", "central_difference"]}
        error.loc[faithful | {"step_size_over_period": [0.01, 0.04]}] = 1.0
        error.loc[{"problem": problem, "scheme": "central_difference", "step_size_over_period": 0.04}] = value
    return xr.Dataset({"max_energy_error": error / 100})


@pytest.mark.parametrize(
    "worst, verdict",
    [
        ({"hardening": 9.9, "softening": 9.9, "double_well": 9.9}, Verdict.REPRODUCED),
        ({"hardening": 9.9, "softening": 9.9, "double_well": 10.1}, Verdict.QUALIFIED),
        ({"hardening": 10.1, "softening": 9.9, "double_well": 9.9}, Verdict.NOT_REPRODUCED),
        ({"hardening": 9.9, "softening": 10.1, "double_well": 9.9}, Verdict.NOT_REPRODUCED),
    ],
)
def test_reasonable_is_an_error_below_ten_per_cent(worst, verdict):
    finding = conclusions.reasonable_below_a_twentieth(_large_steps(**worst))
    assert finding.verdict == verdict
    beyond = [name for name, value in worst.items() if value > 10]
    assert finding.qualification.endswith(f"exceeds 10 % on {' and '.join(beyond).replace('_', ' ')}" if beyond else "")
    assert bool(finding.qualification) == bool(beyond)


@pytest.mark.parametrize(
    "errors, verdict, ours",
    [
        ([10.1] * 7, Verdict.REPRODUCED, "14"),
        ([10.1] * 4 + [9.9] * 3, Verdict.QUALIFIED, "8"),
        ([10.1] * 3 + [9.9] * 4, Verdict.NOT_REPRODUCED, "6"),
    ],
)
def test_unsuitable_is_what_is_not_reasonable_in_most_cells(errors, verdict, ours):
    damped = dict.fromkeys(("newmark_dissipative", "wilson_theta", "houbolt"), errors * 2)
    finding = conclusions.damped_schemes_are_unsuitable(energy_error(**damped))
    assert finding.verdict == verdict and f"houbolt: {ours}, of 14" in finding.ours
    if verdict == Verdict.QUALIFIED:
        assert "for wilson theta at T/100, T/200 and T/1000" in finding.qualification


@pytest.mark.parametrize(
    "worst, order, verdict",
    [(10.1, 2.0, Verdict.REPRODUCED), (9.9, 2.0, Verdict.NOT_REPRODUCED), (10.1, 0.5, Verdict.NOT_REPRODUCED)],
)
def test_accuracy_varies_with_scheme_parameters_and_step(worst, order, verdict):
    data = energy_error(order)
    error = data.max_energy_error
    error.loc[{"scheme": "newmark_dissipative"}] = (worst * error.sel(scheme="rk4")).values
    finding = conclusions.accuracy_varies(data)
    assert finding.verdict == verdict


@pytest.mark.parametrize("ratio, verdict", [(9.9, False), (10.1, True)])
def test_results_vary_greatly_and_one_is_far_better_by_the_same_factor(ratio, verdict):
    data = energy_error()
    error = data.max_energy_error
    error.loc[{"scheme": "rk4"}] = (error.sel(scheme="houbolt") / ratio).values
    assert conclusions.runge_kutta_at_small_steps(data).holds == verdict
    assert comparisons.results_vary(data).holds == verdict


def _beyond(failing=(), error=1.0):
    """Runs at Δt = 0.1 T and 0.3 T; the schemes ``failing`` fail at 0.3 T on the hardening spring."""
    along = {"problem": ["hardening", "softening"], "scheme": SCHEMES, "step_size_over_period": [0.1, 0.3]}
    status = filled(0, **along)
    status.loc[{"problem": "hardening", "scheme": list(failing), "step_size_over_period": 0.3}] = 1
    return xr.Dataset({"status": status, "max_energy_error": filled(error / 100, **along)})


@pytest.mark.parametrize("failing, holds", [(["central_difference", "rk4"], True), (["rk4"], False), ([], False)])
def test_both_explicit_schemes_fail_somewhere_at_large_steps(failing, holds):
    finding = conclusions.explicit_schemes_at_large_steps(_beyond(failing))
    assert finding.holds == holds
    if holds:
        assert finding.qualification == "neither fails on softening"
        assert finding.ours.startswith("central difference: hardening: 0.30; softening: none. rk4: ")


def test_runs_that_fail_below_a_fifth_of_the_period_are_stated():
    data = _beyond(["central_difference", "rk4"])
    data.status.loc[{"scheme": "rk4", "step_size_over_period": 0.1}] = 1
    data.status.loc[{"step_size_over_period": 0.3, "scheme": "rk4"}] = 1
    assert conclusions.explicit_schemes_at_large_steps(data).qualification == "runs of rk4 already fail below T/5"


@pytest.mark.parametrize(
    "failing, error, holds", [(SCHEMES, 1.0, False), (SCHEMES, 51.0, True), ([], 51.0, True), ([], 49.0, False)]
)
def test_meaningless_results_fail_or_are_far_off(failing, error, holds):
    assert conclusions.other_schemes_at_large_steps(_beyond(failing, error)).holds == holds
