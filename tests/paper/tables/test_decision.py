"""The cells of the table of decisions, from made-up runs."""

import numpy as np
import pytest
import xarray as xr

from paper.tables import whole_motion
from paper.tables.decision import NO_BREAK, tabulate
from study.runs.needs import ATTRIBUTES, decisions, needs, of_problems
from tests.runs.made_up import runs, with_kinds

ERRORS = [0.1, 0.01, 0.001]


def _decided() -> xr.Dataset:
    accurate = [[0.2, 0.05, 0.005, 0.0005], [0.05, 0.05, 0.02, 0.02], [0.2] * 4]
    swing = runs(accurate, velocity=[[0.8, 0.8, 0.1, 0.1]] * 3)
    records = runs(accurate, problem="records").assign_coords(quantity=["peak drift", "velocity"])
    found = decisions(with_kinds(of_problems([needs(swing, ERRORS), needs(records.isel(quantity=[0]), ERRORS)])))
    found.verdict.attrs = ATTRIBUTES["verdict"]
    return found


@pytest.fixture(scope="module")
def datasets():
    limits = (("scheme", "damping_ratio"), [[2.0], [np.inf], [np.inf]])
    spectral = xr.Dataset({"stability_limit": limits}, {"scheme": ["cheap", "dear", "stiff"], "damping_ratio": [0.0]})
    return {"decisions": _decided(), "spectral": spectral}


def _rows(table):
    return table.replace(NO_BREAK, " ", regex=True).to_dict("records")


def test_a_cell_has_scheme_step_cost_and_limit(datasets):
    swing, stiff, drift, *_ = _rows(tabulate(**datasets))
    assert (swing["Problem"], swing["Right in"], swing["Scheme"]) == ("Swinging thing", "displacement", "explicit")
    # 16 steps of one force and 8 of two tie, with the same error
    assert swing["10 %"] == "Cheap: 16 (16 forces, ωΔt 0.38 < 2); …"
    assert swing["1 %"] == "Cheap: 32 (32 forces, ωΔt 0.19 < 2)"
    assert swing["0.1 %"] == "Cheap: 64 † (64 forces, ωΔt 0.094 < 2)"
    assert (stiff["Problem"], stiff["Right in"], stiff["10 %"]) == ("", "", "–")
    assert drift["Right in"] == "peak drift" and drift["1 %"] == "Cheap: 62 ms (16 forces/s, ωΔt 0.19 < 2)"


def test_a_row_in_which_the_whole_motion_needs_other_steps_is_marked(datasets):
    remarks = [row["Beware of"] for row in _rows(tabulate(**datasets))]
    assert remarks == ["the whole motion needs other steps", "", "", ""]


def test_the_price_of_the_whole_motion_is_stated_where_it_differs(monkeypatch):
    monkeypatch.setattr(whole_motion, "SHOWN", ["cheap", "dear"])
    # the displacement is within 10 % at 16 steps, the velocity within 75 % at 32 only
    accurate, swinging = (
        [[0.2, 0.05, 0.005, 0.0005], [0.05] * 4, [0.2] * 4],
        [[0.8, 0.8, 0.1, 0.1], [0.1] * 4, [0.1] * 4],
    )
    needed = with_kinds(of_problems([needs(runs(accurate, velocity=swinging), [0.1])]))
    (row,) = whole_motion.tabulate(needed).to_dict("records")
    assert row == {"Problem": "Swinging thing", "Cheap": "16 / 32", "Dear": "8"}
