"""Numbers that the text takes from the ledger and the datasets."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from paper.numbers.__main__ import commits, gathered
from paper.numbers.chaos import windows
from paper.numbers.claims import JUDGED, claim_numbers
from paper.numbers.reproduction import drift_numbers
from paper.products import Product


def _product(name, **numbers):
    return Product("numbers", name, "here", lambda: numbers, {}, "", {})


def test_a_minus_stands_before_numbers_only():
    texts = gathered([_product("a", drift="-0.8", size="2e-16", kind="α-method, T-1"), _product("b", count=3)], str)
    assert texts == {"drift": "−0.8", "size": "2\u00a0×\u00a010⁻¹⁶", "kind": "α-method, T-1", "count": "3"}


def test_one_key_of_two_functions_is_refused():
    with pytest.raises(ValueError, match="The number 'cells' is given by first and by second"):
        gathered([_product("first", cells=1), _product("second", cells=1)], str)


def test_the_commits_of_all_datasets_are_stated():
    known = {"a": "1" * 40, "b": "2" * 40 + "-dirty", "c": "unknown", "d": "1" * 40}
    reads = {"one": ["a", "b"], "another": "c", "third": "d", "table": "claims.csv"}
    product = Product("numbers", "of", "here", dict, reads, "", {})
    assert commits([product], lambda name: xr.Dataset(attrs={"commit": known[name]})) == (
        "111111111111 and 222222222222 with changes"
    )
    assert commits([], str) is None


def test_claims_are_counted_by_part():
    verdicts = ["reproduced", "reproduced with a qualification", "reproduced", "not reproduced", "reproduced"]
    sections, whose = ["3.1", "3.1", "4", "structures", "stability"], [*["Xie"] * 3, "practice", "this study"]
    claims = pd.DataFrame({"section": sections, "whose": whose, "verdict": verdicts, "claim": [*JUDGED, "one", "two"]})
    counts = claim_numbers(claims)
    assert counts["claims"] == 3 and counts["claims_reproduced"] == 2 and counts["claims_qualified"] == 1
    assert not counts["verdicts_confirmed"]  # one of the three claims has a qualification
    assert claim_numbers(claims.assign(verdict="reproduced"))["verdicts_confirmed"]
    assert counts["structure_claims"] == counts["structure_claims_not_reproduced"] == 1
    assert counts["stability_claims_reproduced"] == 1 and counts["stability_claims_qualified"] == 0
    counts = claim_numbers(claims.assign(section="schemes"))
    assert counts["scheme_claims"] == 5 and counts["author_claims"] == 3
    assert counts["practice_claims"] == counts["practice_claims_not_reproduced"] == 1


def test_without_resonance_there_is_no_window():
    parts = np.linspace(15, 30, 31)
    runs = {
        "energy_drift": ("steps_per_period", np.full(31, -0.05)),
        "steps_per_oscillation": ("steps_per_period", parts),
    }
    numbers = drift_numbers(xr.Dataset(runs, {"steps_per_period": parts}))
    assert numbers["resonance_20_from"] == numbers["resonance_20_to"] == "nan" and numbers["drift_20"] == "-5.00"


def test_neighbouring_steps_make_a_window():
    steps = np.array([8, 12, 16, 20, 24])
    assert windows(steps, np.array([True, True, True, False, True])) == "8 to 16 and 24"
    assert windows(steps, np.zeros(5, bool)) is None
