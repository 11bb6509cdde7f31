"""The ledger: its size, its verdicts, and that a check can fail."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import comparisons, conclusions, introduction
from paper.claims.__main__ import main
from paper.claims.ledger import CLAIMS, OURS, XIE, Finding, Verdict, claim, most
from paper.products import PRODUCTS, discover, made


def test_the_ledger_is_whole():
    discover(["claims"])
    assert {claim.section for claim in CLAIMS} >= {"1", "2.1", "2.3", "3", "3.1", "3.2", "4", "5"}
    assert all(claim.statement and claim.quantity and claim.product.reads for claim in CLAIMS)
    assert len({claim.product.name for claim in CLAIMS}) == len(CLAIMS)


def test_the_paper_is_quoted_in_short_and_nobody_else():
    discover(["claims"])
    for one in CLAIMS:
        assert (one.whose == XIE) == (one.section not in OURS), one.statement
        assert 8 < len(one.words) <= 150 if one.whose == XIE else not one.words, one.statement
    assert len({one.words for one in CLAIMS if one.words}) == sum(one.whose == XIE for one in CLAIMS)
    assert {one.whose for one in CLAIMS} >= {"Xie", "Xie, extended", "practice", "this study"}


@pytest.fixture
def entered(monkeypatch):
    """Claims and products that a test enters are forgotten after it."""
    monkeypatch.setattr("paper.claims.ledger.CLAIMS", [])
    monkeypatch.setattr("paper.products.PRODUCTS", {})


def _entered(section, check, reads):
    """The product of a new claim."""
    claim(section, "Said so.", "something", words="said so" if section == "4" else "", reads=reads)(check)
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


@pytest.mark.parametrize("section, words", [("4", ""), ("stability", "said so")])
def test_a_claim_of_the_paper_needs_its_words_and_another_has_none(entered, section, words):
    with pytest.raises(ValueError, match="must quote the paper if it is in a section of it, and only then"):
        claim(section, "Said so.", "something", words=words, reads=["energy_error"])


def test_claims_of_the_paper_are_numbered_apart_and_stand_first(entered, monkeypatch, tmp_path):
    for section, name in (("stability", "last"), ("4", "second"), ("3", "first")):
        words = "" if section == "stability" else "said so"
        check = lambda data: Finding("1", True)  # noqa: E731
        check.__name__ = name
        claim(section, name, "something", words=words, whose="practice", reads=[])(check)
    monkeypatch.setattr("paper.claims.__main__.discover", lambda places: None)
    from paper.claims.ledger import CLAIMS

    monkeypatch.setattr("paper.claims.__main__.CLAIMS", CLAIMS)
    main(tmp_path, tmp_path / "claims.csv")
    rows = [line.split(",")[:4] for line in (tmp_path / "claims.csv").read_text().splitlines()]
    assert rows == [
        ["number", "section", "whose", "claim"],
        ["1", "3", "Xie", "first"],
        ["2", "4", "Xie", "second"],
        ["A1", "stability", "practice", "last"],
    ]


@pytest.mark.parametrize(
    "cells, holds, exceptions",
    [
        ({"a": True, "b": True, "c": False}, True, ["c"]),
        ({"a": True, "b": False}, False, ["b"]),
        ({"a": True}, True, []),
    ],
)
def test_a_statement_about_cells_holds_in_most_of_them(cells, holds, exceptions):
    assert most(cells) == (holds, exceptions)


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
    assert conclusions.newmark_should_never_be_used(_tables({"newmark_dissipative": 10.1})).holds
    assert not conclusions.newmark_should_never_be_used(_tables({"newmark_dissipative": 9.9})).holds


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
