"""Facts and values for the text: on schemes since 1996, from the ledger, and on other programs."""

import pandas as pd
import pytest
import xarray as xr

from paper.claims.ledger import CLAIMS, Verdict
from paper.numbers.later_schemes import STATED, VALUES, WITH_MODEL, later_scheme_numbers
from paper.numbers.other_programs import other_program_numbers
from paper.products import discover
from paper.tables.other_programs import tabulate

STATEMENTS = {statement: verdict for verdict, *statements in STATED.values() for statement in statements}


def _numbers(**changed):
    claims = pd.DataFrame({"claim": STATEMENTS.keys(), "verdict": STATEMENTS.values(), "ours": "KR-α: 1; 2.5; 3"})
    claims.loc[claims.claim.isin(changed), "verdict"] = Verdict.UNDECIDED
    chosen = [[[["central_difference", ""], ["bathe", "houbolt"]], [["bathe", "bathe"], ["bathe", "bathe"]]]]
    decisions = xr.Dataset(
        {"scheme": (("filter", "quantity", "kind", "allowed_error"), chosen)},
        # the table of decisions has no rows for the velocity
        {"filter": ["all"], "quantity": ["displacement", "velocity"], "kind": ["explicit", "implicit"]},
    )
    needs = xr.Dataset(
        coords={
            "scheme": ["central_difference", "bathe", "houbolt"],
            "scheme_source": ("scheme", ["Newmark (1959)", "Bathe and Baig (2005)", "Houbolt (1950)"]),
        }
    )
    with_model = [*WITH_MODEL, "kr_alpha_dissipative"]
    ratios = xr.DataArray([[401, 5.0]] * 4, {"with_model": with_model, "omega_step": [0.1, 1.0]})
    return later_scheme_numbers(claims, decisions, needs, xr.Dataset({"largest_stiffening": ratios}))


def test_facts_need_the_verdict_of_all_their_statements():
    assert all(_numbers()[fact] for fact in STATED)
    for fact, (_, *statements) in STATED.items():
        assert not _numbers(**{statements[0]: None})[fact]


def test_values_and_choices():
    numbers = _numbers()
    assert numbers["overshoot_kr"] == "1" and numbers["overshoot_mkr"] == "2.5" and numbers["period_error_mkr"] == "3"
    assert numbers["later_explicit"] == "0 of 1" and numbers["later_implicit"] == "1 of 2"
    assert numbers["model_excess"] == "4"


def test_the_statements_are_in_the_ledger():
    discover(["claims"])
    assert STATEMENTS.keys() <= {claim.statement for claim in CLAIMS}
    assert all(fact in STATED for fact, _ in VALUES.values())


def test_other_programs():
    table, numbers = tabulate(), other_program_numbers()
    assert (table["Cases"] == table[["As named", "Alternative", "Fail"]].sum(axis=1)).all()
    assert (table["Cases"] <= numbers["kit_cases"]).all()
    # OpenSees, Exudyn, fedoo, Kratos, MFEM, PETSc, ROSS, SfePy and xara, but not Akantu, MuJoCo, diffrax and SciPy
    assert (numbers["kit_programs"], numbers["kit_programs_failing"]) == (13, 9)
    (row,) = (row for _, row in table.iterrows() if row["Program"] == "OpenSees (3.8.0)")
    assert numbers["kit_opensees_passed"] == row["As named"]
    assert float(numbers["kit_opensees_order"]) == pytest.approx(1, abs=0.1)
