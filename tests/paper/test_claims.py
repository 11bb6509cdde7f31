"""The ledger: its size, its verdicts, and that a check can fail."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import comparisons, conclusions, discussion, introduction
from paper.claims.ledger import CLAIMS, Finding, Verdict


def test_the_ledger_is_whole():
    assert len(CLAIMS) >= 35
    assert {claim.section for claim in CLAIMS} >= {"1", "2.1", "2.3", "3.1", "3.2", "4", "5"}
    assert all(claim.statement and claim.quantity for claim in CLAIMS)


@pytest.mark.parametrize(
    "finding, verdict",
    [
        (Finding("1", True), Verdict.REPRODUCED),
        (Finding("1", True, "but"), Verdict.QUALIFIED),
        (Finding("1", False, "as"), Verdict.NOT_REPRODUCED),
        (Finding("1", False), Verdict.NOT_REPRODUCED),
    ],
)
def test_verdicts(finding, verdict):
    assert finding.verdict == verdict


def _tables(values):
    """A dataset as energy_error.nc has it, with one value everywhere but where told."""
    schemes = ["average_acceleration", "central_difference", "newmark_dissipative", "wilson_theta", "houbolt",
               "hht_alpha", "rk4"]  # fmt: skip
    steps = [15, 20, 25, 50, 100, 200, 1000]
    error = xr.DataArray(
        np.full((1, 2, 7, 7), 5.0),
        coords={"period_used": ["printed"], "problem": ["hardening", "softening"], "steps_per_period": steps,
                "scheme": schemes},
        dims=["period_used", "problem", "steps_per_period", "scheme"],
    )  # fmt: skip
    for scheme, value in values.items():
        error.loc[{"scheme": scheme}] = value
    return {"energy_error": xr.Dataset({"max_energy_error": error})}


def test_a_claim_follows_the_data():
    assert comparisons.newmark_is_worst(_tables({"newmark_dissipative": 99.0})).holds
    assert not comparisons.newmark_is_worst(_tables({"houbolt": 99.0})).holds
    assert conclusions.newmark_should_never_be_used(_tables({"newmark_dissipative": 900.0})).holds
    assert not conclusions.newmark_should_never_be_used(_tables({})).holds
    assert discussion.runge_kutta_at_a_twentieth(_tables({"rk4": 1.04})).holds
    assert not discussion.runge_kutta_at_a_twentieth(_tables({"rk4": 1.2})).holds


def test_the_start_of_houbolt_is_decided_by_the_digit():
    def starts(linear):
        error = xr.DataArray(
            [[[linear, 97.346]]],
            coords={"problem": ["hardening"], "steps_per_period": [20], "start": ["linear_acceleration", "taylor"]},
            dims=["problem", "steps_per_period", "start"],
        )
        return {"houbolt_start": xr.Dataset({"max_energy_error": error})}

    assert introduction.start_of_houbolt(starts(97.342)).holds
    assert not introduction.start_of_houbolt(starts(97.348)).holds
