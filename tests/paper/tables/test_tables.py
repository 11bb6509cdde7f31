"""Tables that are made from maps, from sufficient numbers of steps and from the ledger."""

import numpy as np
import pandas as pd
import xarray as xr

from paper.measures.outcomes import accurate_up_to, first_of, near_1996
from paper.tables import claims, outcomes_near_1996, robustness

NAMES = ["accurate", "bounded", "damped_to_rest", "in_the_wrong_well", "chaotic", "growing", "no_solution_found"]


def atlas() -> xr.Dataset:
    """One scheme on two springs, three amplitudes and four step sizes; the first amplitude is left out of the table."""
    outcome = np.zeros((1, 2, 3, 4), np.int8)
    outcome[0, :, 0] = 5
    outcome[0, 0, 1] = [0, 0, 1, 4]
    outcome[0, 0, 2] = [0, 1, 0, 6]
    outcome[0, 1, 1] = [0, 0, 0, 2]
    meanings = " ".join([*NAMES, "unbounded"])
    return xr.Dataset(
        {
            "outcome": (
                ("scheme", "problem", "amplitude", "step_size_over_period"),
                outcome,
                {"flag_meanings": meanings},
            )
        },
        coords={
            "scheme": ["own"],
            "scheme_title": ("scheme", ["Own"]),
            "family": ("scheme", ["Own"]),
            "problem": ["hardening", "softening"],
            "amplitude": [0.1, 1.0, 2.0],
            "step_size_over_period": [0.01, 0.1, 0.2, 0.5],
        },
    )


def test_boundaries():
    near = near_1996(atlas())
    assert near.amplitude.values.tolist() == [1.0, 2.0]
    # accurate runs at larger steps than an inaccurate run do not count
    assert accurate_up_to(near).sel(scheme="own").values.tolist() == [0.01, 0.2]
    assert first_of(near, "chaotic").sel(scheme="own").values.tolist() == [0.5, np.inf]
    assert np.isinf(first_of(near, "growing")).all()


def test_the_table_names_the_spring_that_comes_first():
    (row,) = outcomes_near_1996.tabulate(atlas()).to_dict("records")
    assert row["1 % up to"] == "0.01 (h)" and row["Chaotic"] == "0.5 (h)" and row["Damped to rest"] == "0.5 (s)"
    assert row["Growing"] == row["Unbounded"] == "–" and row["No solution"] == "0.5 (h)"


def test_the_longest_runs_count_and_the_most_steps_stand_for_failure():
    needed = np.array([[[20.0, 40.0], [10.0, np.nan]]])  # steps by problem, level and length of runs
    steps = xr.Dataset(
        {
            "fewest_steps_per_period": (("problem", "scheme", "allowed_error", "periods"), needed[:, None]),
            "most_steps_per_period": ((), 256),
        },
        coords={
            "problem": ["softening"],
            "problem_title": ("problem", ["softening spring"]),
            "scheme": ["own"],
            "scheme_title": ("scheme", ["Own"]),
            "allowed_error": [0.05, 0.01],
            "periods": [10, 100],
        },
    )
    (row,) = robustness.tabulate(steps).to_dict("records")
    assert row == {"Scheme": "Own", "Softening 5 %": "40", "Softening 1 %": "> 256"}


_ROW = {"number": "1", "claim": "It grows.", "quantity": "size", "printed": "", "ours": "2", "verdict": "reproduced"}


def test_the_table_states_whose_a_claim_is():
    ledger = pd.DataFrame(
        [
            _ROW | {"section": "3.1", "whose": "Xie", "words": "is growing", "reason": "but slowly"},
            _ROW | {"section": "stability", "whose": "practice", "words": "", "reason": ""},
        ]
    )
    first, second = claims.tabulate(ledger).to_dict("records")
    assert first["Whose"] == "Xie, 3.1" and second["Whose"] == "practice"
    assert first["Claim"] == "It grows. “is growing”" and second["Claim"] == "It grows."
    assert first["Verdict"] == "reproduced; but slowly" and second["Verdict"] == "reproduced"
