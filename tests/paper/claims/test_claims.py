"""The ledger: its size, its verdicts, and that a check can fail."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import comparisons, conclusions, discussion, introduction
from paper.claims.ledger import CLAIMS, Finding, Verdict, claim
from paper.products import PRODUCTS, discover, made


def test_the_ledger_is_whole():
    discover(["claims"])
    assert len(CLAIMS) >= 35
    assert {claim.section for claim in CLAIMS} >= {"1", "2.1", "2.3", "3.1", "3.2", "4", "5"}
    assert all(claim.statement and claim.quantity and claim.product.reads for claim in CLAIMS)
    assert len({claim.product.name for claim in CLAIMS}) == len(CLAIMS)


@pytest.fixture
def entered(monkeypatch):
    """Claims and products that a test enters are forgotten after it."""
    monkeypatch.setattr("paper.claims.ledger.CLAIMS", [])
    monkeypatch.setattr("paper.products.PRODUCTS", {})


def _entered(section, check, reads):
    """The product of a new claim."""
    claim(section, "Said so.", "something", reads=reads)(check)
    from paper.claims.ledger import CLAIMS

    return CLAIMS[-1].product


def test_a_claim_sees_no_dataset_that_it_does_not_declare(entered):
    product = _entered("4", lambda data: Finding("", "energy_drift" in data or data["cpu_time"]), ["energy_error"])
    with pytest.raises(
        ValueError, match=r"The claim 'Said so\.' reads the dataset 'cpu_time', which it does not declare"
    ):
        made(product, _tables({}).__getitem__)


@pytest.mark.parametrize("section", ["structure", "6", "3.1.2", ""])
def test_a_section_is_the_papers_or_one_of_ours(entered, section):
    with pytest.raises(
        ValueError, match=f"is in section '{section}', which is neither numbered as the paper's nor one of"
    ):
        claim(section, "Said so.", "something", reads=["energy_error"])
    assert not PRODUCTS.keys() & {("claim", "Said so.")}


@pytest.mark.parametrize("section, seen", [("4", 7), ("stability", 8)])
def test_claims_of_the_paper_see_its_schemes_alone(entered, section, seen):
    tables = _tables({})["energy_error"]
    later = tables.isel(scheme=[0]).assign_coords(scheme=["bathe"])
    both = xr.concat([later, tables], "scheme")
    product = _entered(section, lambda data: Finding(str(data["energy_error"].sizes["scheme"]), True), ["energy_error"])
    assert made(product, lambda name: both).ours == str(seen)
    asks = {"energy_error.schemes", "energy_error.problems"}
    assert asks <= product.asks.keys() if section == "4" else not product.asks


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


@pytest.mark.parametrize("error, holds", [(9.9, True), (10.1, False)])
def test_an_error_above_ten_percent_is_not_reasonable(error, holds):
    names = ["hardening", "softening"]
    errors = xr.DataArray(
        np.full((2, 2, 2), [error, 99.0]),
        coords={
            "problem": names,
            "scheme": ["average_acceleration", "central_difference"],
            "dt_over_period": [0.05, 0.1],
        },
        dims=["problem", "scheme", "dt_over_period"],
    )
    finding = conclusions.reasonable_below_a_twentieth({"large_steps": xr.Dataset({"max_energy_error": errors})})
    assert finding.holds == holds
    assert ("not at every amplitude" in finding.qualification) != holds
