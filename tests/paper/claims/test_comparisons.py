"""Claims of sections 2 and 3 on made-up datasets: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import comparisons, softening
from paper.claims.ledger import Verdict
from paper.published import STEPS
from paper.terms import DISSIPATIVE
from tests.paper.claims.made_up import accuracy, energy_error


@pytest.mark.parametrize(
    "energy, displacement, verdict",
    [
        (1.0, 1.0, Verdict.REPRODUCED),
        (99.0, 99.0, Verdict.REPRODUCED),
        (1.0, 99.0, Verdict.NOT_REPRODUCED),
        (99.0, 1.0, Verdict.NOT_REPRODUCED),
    ],
)
def test_energy_measures_inaccuracy_if_it_judges_as_the_displacement_does(energy, displacement, verdict):
    assert comparisons.energy_measures_inaccuracy(accuracy(energy, displacement)).verdict == verdict


def test_energy_that_does_not_see_some_errors_is_a_measure_with_a_qualification():
    data = accuracy()
    data.displacement_error.loc[{"problem": "hardening", "steps_per_period": 16}] = 2.0
    finding = comparisons.energy_measures_inaccuracy(data)
    assert finding.verdict == Verdict.QUALIFIED and finding.ours == "21 of 28"
    assert (
        "of 28 runs with an energy error up to that bound, 7 have a larger displacement error" in finding.qualification
    )


@pytest.mark.parametrize(
    "few, many, verdict",
    [
        (2.1, 2.1, Verdict.REPRODUCED),
        (1.9, 2.1, Verdict.QUALIFIED),
        (2.1, 1.9, Verdict.NOT_REPRODUCED),
    ],
)
def test_significantly_more_accurate_is_decided_over_all_step_sizes(few, many, verdict):
    errors = np.full(len(STEPS), many)
    errors[:2] = few
    data = energy_error(newmark_dissipative=np.tile(errors, 2), hht_alpha_1996=1.0)
    finding = comparisons.alpha_helps(data)
    assert finding.verdict == verdict
    assert (finding.qualification == "at T/15 and T/20 by a factor of less than 2") == (verdict == Verdict.QUALIFIED)


@pytest.mark.parametrize("steps, holds", [(slice(None), True), (slice(4, None), False)])
def test_runge_kutta_converges_fastest_between_all_step_sizes(steps, holds):
    data = energy_error()
    rk4 = {"scheme": "rk4"}
    error = data.max_energy_error
    order = xr.where(np.isin(STEPS, STEPS[steps]), 4.0, 1.0)
    falls = np.cumprod([1.0, *(np.array(STEPS[:-1]) / STEPS[1:]) ** order[1:]])
    error.loc[rk4] = np.broadcast_to(falls, (1, 2, len(STEPS)))
    assert comparisons.runge_kutta_converges_fastest(data).holds == holds


@pytest.mark.parametrize(
    "energy, drift, ours, holds",
    [(51.0, -51.0, "6 of 6", True), (99.0, 99.0, "0 of 6", False), (49.0, -49.0, "0 of 0", False)],
)
def test_grave_errors_are_damping_where_all_lose_energy(energy, drift, ours, holds):
    finding = comparisons.grave_errors_are_damping(accuracy(energy, 99.0, drift))
    assert (finding.ours, finding.holds) == (ours, holds)


@pytest.mark.parametrize("periods, holds", [(9, True), (11, False), (200, False)])
def test_rapidly_is_within_some_periods(periods, holds):
    t = np.linspace(0, 15, 2001)
    energy = xr.DataArray(np.where(t > periods * 0.15, -1.0, 0.0), {"t": t}, "t").expand_dims(scheme=DISSIPATIVE)
    data = energy.to_dataset(name="energy_error")
    assert comparisons.newmark_goes_to_rest(data).holds == holds


@pytest.mark.parametrize(
    "ranks, correlation, holds", [([2, 1, 0, 4, 3, 5, 6], 0.82, True), ([2, 1, 0, 4, 3, 6, 5], 0.79, False)]
)
def test_the_springs_agree_where_they_rank_the_schemes_alike(ranks, correlation, holds):
    data = energy_error()
    error = data.max_energy_error
    error.loc[{"problem": "hardening"}] = np.broadcast_to(range(7), (1, len(STEPS), 7))
    error.loc[{"problem": "softening"}] = np.broadcast_to(ranks, (1, len(STEPS), 7))
    finding = softening.springs_agree(data)
    assert finding.holds == holds and finding.ours == f"{correlation}, at T/15"


@pytest.mark.parametrize("error, holds", [(39.449, True), (39.41, False)])
def test_a_printed_error_is_reproduced_to_its_digit(error, holds):
    from paper.claims.ledger import CLAIMS

    (entered,) = (claim for claim in CLAIMS if claim.printed == "39.5 %" and claim.section == "3.1")
    assert entered.product.function(energy_error=energy_error(newmark_dissipative=error)).holds == holds
