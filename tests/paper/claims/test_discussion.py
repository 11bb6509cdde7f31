"""Claims of section 4 on made-up datasets: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import discussion, double_well
from paper.claims.ledger import Verdict
from paper.published import SCHEMES
from paper.terms import DAMPED
from tests.paper.claims.made_up import energy_error, filled

#: Step sizes as fractions of the period. They form 80 pairs of neighbours, and a twentieth of these pairs is four.
STEPS = [round(0.01 * k, 2) for k in range(1, 82)]


def _large_steps(*worse):
    """Errors that rise with the step size; only at the indices ``worse`` the next larger step has a smaller error."""
    error = filled(1.0, problem=["softening_large"], scheme=["average_acceleration"], step_size_over_period=STEPS)
    error = error * np.arange(1, len(STEPS) + 1)
    for index in worse:
        error[..., index] = 3 * error[..., index + 1]
    return error.to_dataset(name="max_energy_error")


@pytest.mark.parametrize("worse, holds", [([5], False), ([5, 15, 25, 35], False), ([5, 15, 25, 35, 45], True)])
def test_not_uncommon_is_more_than_one_case_in_twenty(worse, holds):
    finding = discussion.smaller_may_be_worse(_large_steps(*worse))
    assert finding.holds == holds
    assert finding.qualification == "in Tables 1 and 2 it happens in 1 of 84 pairs"


@pytest.mark.parametrize("small, large, holds", [(102.0, 9.9, True), (100.0, 9.9, False), (150.0, 10.1, False)])
def test_a_smaller_step_is_unstable_next_to_a_larger_reasonable_one(small, large, holds):
    data = _large_steps()
    data.max_energy_error[..., :] = 0.5
    data.max_energy_error[..., 3] = small / 100
    data.max_energy_error[..., 5] = large / 100
    assert discussion.smaller_may_be_unstable(data).holds == holds


@pytest.mark.parametrize(
    "gains, holds, qualified",
    [([2, 3, 4], True, ""), ([0.5, 3, 4], True, "67 % of 3 such"), ([0, 0.5, 3], False, "33 % of 3 such")],
)
def test_the_alpha_method_is_unstable_if_most_close_runs_gain_energy(gains, holds, qualified):
    gain = xr.DataArray(
        [[gains]], dims=["scheme", "step_size_over_period", "start"], coords={"scheme": ["hht_alpha_1996"]}
    )
    finding = discussion.alpha_is_unstable(gain.to_dataset(name="largest_gain"))
    assert finding.holds == holds and qualified in finding.qualification
    assert bool(finding.qualification) == bool(qualified)


def _double_well(lost=900 / 7, gained=0.0, undamped=0.0):
    """Signed energy errors of all schemes; arguments are in percent. By default the damped schemes end at rest."""
    error = filled(0.0, scheme=SCHEMES, t=[0.0, 2.5, 5.0])
    error.loc[{"scheme": DAMPED, "t": 5.0}] = -lost
    error.loc[{"scheme": "hht_alpha_1996", "t": 2.5}] = gained
    error.loc[{"scheme": "average_acceleration", "t": 2.5}] = undamped
    return (error / 100).to_dataset(name="energy_error")


@pytest.mark.parametrize(
    "run, verdict",
    [
        ({}, Verdict.REPRODUCED),
        ({"undamped": 200.0}, Verdict.QUALIFIED),
        ({"lost": 20.0}, Verdict.NOT_REPRODUCED),
        ({"gained": 200.0}, Verdict.NOT_REPRODUCED),
    ],
)
def test_damping_is_the_cause_where_all_energy_is_lost_and_none_gained(run, verdict):
    finding = double_well.damping_is_the_cause(_double_well(**run))
    assert finding.verdict == verdict
    if run == {}:
        assert finding.ours.endswith("hht alpha 1996: 100")


@pytest.mark.parametrize("lengths, holds", [([3, 4, 5, 6, 7, 8], True), ([3, 4, 5, 6, 7, 3], False)])
def test_jumps_are_irregular_if_the_stays_differ(lengths, holds):
    signs = [sign for k, length in enumerate([1, *lengths, 1]) for sign in [(-1.0) ** k] * length]
    u = xr.DataArray([signs], {"scheme": ["average_acceleration"]}, ["scheme", "t"])
    changes = xr.DataArray([[7, 9]], {"scheme": ["average_acceleration"]}, ["scheme", "start"])
    finding = double_well.jumps_between_wells(u.to_dataset(name="u"), changes.to_dataset(name="changes_of_sign"))
    assert finding.holds == holds and finding.ours.startswith("7 to 9; ")


@pytest.mark.parametrize("excess, holds", [(9e-11, True), (1.1e-10, False)])
def test_unconditionally_stable_is_up_to_round_off(excess, holds):
    radius = filled(1 + excess, scheme=SCHEMES, damping_ratio=[0.0], step_size_over_period=[0.1])
    radius.loc[{"scheme": ["central_difference", "rk4"]}] = 2.0
    data = radius.to_dataset(name="spectral_radius")
    assert discussion.five_are_unconditionally_stable(data).holds == holds
    radius.loc[{"scheme": "rk4"}] = 1.0
    assert not discussion.five_are_unconditionally_stable(data).holds


@pytest.mark.parametrize("steps, verdict", [(20.04, Verdict.QUALIFIED), (20.06, Verdict.REPRODUCED)])
def test_the_best_scheme_is_an_accident_only_in_a_resonance(steps, verdict):
    drift = xr.Dataset({"steps_per_oscillation": ("steps_per_period", [steps])}, {"steps_per_period": [20.0]})
    finding = discussion.runge_kutta_is_best(energy_error(rk4=0.1), drift)
    assert finding.verdict == verdict


@pytest.mark.parametrize(
    "flags, verdict",
    [((1, 1), Verdict.QUALIFIED), ((1, 2), Verdict.REPRODUCED), ((0, 1), Verdict.NOT_REPRODUCED)],
)
def test_explicit_schemes_find_no_solution_if_both_fail(flags, verdict):
    status = xr.DataArray(list(flags), {"scheme": ["central_difference", "rk4"]}, ["scheme"])
    status.attrs["flag_meanings"] = "complete not_finite no_solution_found"
    portrait = xr.Dataset({"status": status, "failed_at_step": status + 6})
    finding = double_well.explicit_schemes_fail(portrait)
    assert finding.verdict == verdict and "rk4: " in finding.ours and finding.ours.endswith(f"at step {flags[1] + 6}")
