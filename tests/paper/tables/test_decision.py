"""The cells of the table of decisions, from made-up runs."""

import numpy as np
import pytest
import xarray as xr

from paper.tables import whole_motion
from paper.tables.decision import COLUMNS, NO_BREAK, tabulate
from study.runs.needs import ATTRIBUTES, decisions, joined_needs, needs
from tests.runs.made_up import runs, with_kinds

ERRORS = [0.1, 0.01, 0.001]


def _decided() -> xr.Dataset:
    accurate = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2] * 4]
    swing = runs(accurate, velocity=[[0.8, 0.8, 0.1, 0.1]] * 3)
    records = runs(accurate, problem="records").assign_coords(quantity=["peak drift", "velocity"])
    decided = decisions(with_kinds(joined_needs([needs(swing, ERRORS), needs(records.isel(quantity=[0]), ERRORS)])))
    decided.verdict.attrs = ATTRIBUTES["verdict"]
    return decided


@pytest.fixture(scope="module")
def datasets():
    limits = (("scheme", "damping_ratio"), [[2.0], [np.inf], [np.inf]])
    spectral = xr.Dataset({"stability_limit": limits}, {"scheme": ["cheap", "dear", "stiff"], "damping_ratio": [0.0]})
    return {"decisions": _decided(), "spectral": spectral}


def _rows(table):
    return table.replace(NO_BREAK, " ", regex=True).to_dict("records")


@pytest.mark.slow
def test_a_row_has_scheme_step_cost_and_limit(datasets):
    rows = _rows(tabulate(**datasets))
    assert [row["Error"] for row in rows] == ["10 %", "1 %", "0.1 %"] * 4
    assert {(row["Problem"], row["Right in"]) for row in rows[:6]} == {("Swinging thing", "displacement")}
    assert [row["Kind"] for row in rows[:6]] == ["explicit"] * 3 + ["implicit"] * 3
    cells = [[row[name] for name in COLUMNS] for row in rows]
    # 16 steps of one force and 8 of two tie, with the same error
    assert cells[0] == ["Cheap", "…", "16", "16", "", "0.38", "2"]
    assert cells[1] == ["Cheap", "", "32", "32", "", "0.19", "2"]
    assert cells[2] == ["Cheap", "", "64 †", "64", "", "0.094", "2"]
    assert cells[3] == ["–", "", "", "", "", "", ""]
    assert rows[7]["Right in"] == "peak drift" and cells[7] == ["Cheap", "", "62.5 ms", "16", "", "0.19", "2"]


def test_a_row_in_which_the_whole_motion_needs_other_steps_is_marked(datasets):
    remarks = [row["Beware of"] for row in _rows(tabulate(**datasets))]
    assert remarks == ["the whole motion needs other steps at some error"] * 3 + [""] * 9


def test_the_price_of_the_whole_motion_is_stated_where_it_differs(monkeypatch):
    monkeypatch.setattr(whole_motion, "SHOWN", ["cheap", "dear"])
    # the displacement is within 10 % at 16 steps, the velocity within 75 % at 32 only
    accurate, swinging = (
        [[0.2, 0.05, 0.005, 0.0005], [0.05] * 4, [0.2] * 4],
        [[0.8, 0.8, 0.1, 0.1], [0.1] * 4, [0.1] * 4],
    )
    needed = with_kinds(joined_needs([needs(runs(accurate, velocity=swinging), [0.1])]))
    (row,) = whole_motion.tabulate(needed).to_dict("records")
    assert row == {"Problem": "Swinging thing", "Cheap": "16 / 32", "Dear": "8"}
