"""Claims on costs: a ratio lies beyond a bound only if both quartiles of its repeats lie beyond it."""

import pytest

from paper.claims import costs
from paper.claims.ledger import Verdict
from tests.paper.claims.made_up import times


@pytest.mark.parametrize(
    "repeats, holds, reason",
    [
        ([7.4, 7.4, 7.4, 7.4], True, ""),
        ([7.6, 7.6, 7.6, 7.6], False, "not so for hardening; this depends on the processor"),
        ([7.4, 7.4, 7.6, 7.6], False, "the repeats do not decide for hardening; this depends on the processor"),
    ],
)
def test_much_less_is_decided_by_the_quartiles(repeats, holds, reason):
    finding = costs.central_difference_is_cheap(times(central_difference=repeats))
    assert (finding.holds, finding.qualification) == (holds, reason)
    assert (finding.verdict == Verdict.UNDECIDED) == ("do not decide" in reason)


@pytest.mark.parametrize("dearer, verdict", [(["houbolt", "hht_alpha_1996"], True), (["houbolt"], False)])
def test_what_costs_more_is_decided_in_most_cells(dearer, verdict):
    finding = costs.others_cost_more(times(wilson_theta=9.0, **dict.fromkeys(dearer, 12.0)))
    assert finding.holds == verdict and "Wilson" not in finding.ours
    assert finding.qualification.startswith("not so for wilson theta on the hardening")


def test_twice_the_time_is_compared_repeat_by_repeat():
    data = times()
    assert not costs.softening_costs_twice(data).holds
    data.seconds_per_step.loc[{"problem": "softening"}] = [25.0, 50.0, 25.0, 25.0]
    data.seconds_per_step.loc[{"problem": "hardening", "repeat": 1}] = 20.0
    assert costs.softening_costs_twice(data).holds
