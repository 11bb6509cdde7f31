"""The ledger of claims: its size, its verdicts, and the data that decide them."""

import pytest
import xarray as xr

from paper.claims import comparisons, conclusions, introduction
from paper.claims.__main__ import main
from paper.claims.ledger import CLAIMS, OURS, XIE, Finding, Verdict, claim, most
from paper.products import content_of, discover
from paper.published import SCHEMES
from tests.paper.claims.made_up import energy_error


def test_the_ledger_is_whole():
    discover(["claims"])
    assert {claim.section for claim in CLAIMS} >= {"1", "2.1", "2.3", "3", "3.1", "3.2", "4", "5"}
    assert all(claim.statement and claim.quantity and claim.product.reads for claim in CLAIMS)
    assert len({claim.product.name for claim in CLAIMS}) == len(CLAIMS)


def test_the_paper_is_quoted_in_short_and_nobody_else():
    discover(["claims"])
    for entry in CLAIMS:
        assert (entry.whose == XIE) == (entry.section not in OURS), entry.statement
        assert 8 < len(entry.words) <= 150 if entry.whose == XIE else not entry.words, entry.statement
    assert len({entry.words for entry in CLAIMS if entry.words}) == sum(entry.whose == XIE for entry in CLAIMS)
    assert {entry.whose for entry in CLAIMS} >= {"Xie", "Xie, extended", "practice", "this study"}


@pytest.fixture
def entered(monkeypatch):
    """Make the lists of claims and products empty for a test, and restore them after it."""
    monkeypatch.setattr("paper.claims.ledger.CLAIMS", [])
    monkeypatch.setattr("paper.products.PRODUCTS", {})


def _entered(section, check):
    """Enter a claim, and return its product."""
    claim(section, "Said so.", "something", words="said so" if section == "4" else "")(check)
    from paper.claims.ledger import CLAIMS

    return CLAIMS[-1].product


@pytest.mark.parametrize("section, words", [("4", ""), ("structure", ""), ("stability", "said so")])
def test_a_claim_of_the_paper_needs_its_words_and_another_has_none(entered, section, words):
    with pytest.raises(ValueError, match=f"'Said so.' is in section '{section}'. Claims in adaptive, materials, sch"):
        claim(section, "Said so.", "something", words=words)


def test_claims_of_the_paper_are_numbered_apart_and_stand_first(entered, monkeypatch, tmp_path):
    for section, name in (("stability", "last"), ("4", "second"), ("3", "first")):
        words = "" if section == "stability" else "said so"
        claim(section, name, "something", words=words, whose="practice")(lambda: Finding("1", True))
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
    tables = energy_error()
    later = tables.isel(scheme=[0]).assign_coords(scheme=["bathe"])
    both = xr.concat([later, tables], "scheme")
    product = _entered(section, lambda energy_error: Finding(str(energy_error.sizes["scheme"]), True))
    assert content_of(product, lambda name: both).ours == str(seen)
    assert product.requires == ({"energy_error.schemes": SCHEMES} if section == "4" else {})


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


def test_a_claim_follows_the_data():
    assert comparisons.newmark_is_worst(energy_error(newmark_dissipative=99.0)).holds
    assert not comparisons.newmark_is_worst(energy_error(houbolt=99.0)).holds
    chosen = xr.DataArray([["bathe", "newmark_dissipative"]], dims=("problem", "allowed_error"))
    coords = {"problem": ["yielding"], "allowed_error": [0.01, 0.1]}
    both = chosen.expand_dims(filter=["all"], quantity=["displacement"], kind=["implicit"]).assign_coords(coords)
    errors, elsewhere = energy_error(newmark_dissipative=10.1), both.to_dataset(name="scheme")
    claimed = conclusions.newmark_should_never_be_used(errors, elsewhere)
    assert claimed.holds and claimed.qualification.endswith("for an error of 10 % on the yielding")
    claimed = conclusions.newmark_should_never_be_used(energy_error(newmark_dissipative=9.9), elsewhere)
    assert not claimed.holds


def test_the_start_of_houbolt_is_decided_by_the_digit():
    def starts(linear):
        error = xr.DataArray(
            [[[linear, 97.346]]],
            coords={"problem": ["hardening"], "steps_per_period": [20], "start": ["linear_acceleration", "taylor"]},
            dims=["problem", "steps_per_period", "start"],
        )
        return xr.Dataset({"max_energy_error": error / 100})

    assert introduction.start_of_houbolt(starts(97.342)).holds
    assert not introduction.start_of_houbolt(starts(97.348)).holds
