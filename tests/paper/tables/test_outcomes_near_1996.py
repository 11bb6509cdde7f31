"""What the table of outcomes near those of 1996 reads off a map."""

import numpy as np
import xarray as xr

from paper.tables.outcomes_near_1996 import accurate_up_to, first_of, near_1996, tabulate

NAMES = ["accurate", "bounded", "damped_to_rest", "in_the_wrong_well", "chaotic", "growing", "newton_not_converged"]


def atlas() -> xr.Dataset:
    """One scheme on two springs, three amplitudes and four step sizes; the first amplitude is left out of the table."""
    outcome = np.zeros((1, 2, 3, 4), np.int8)
    outcome[0, :, 0] = 5
    outcome[0, 0, 1] = [0, 0, 1, 4]
    outcome[0, 0, 2] = [0, 1, 0, 6]
    outcome[0, 1, 1] = [0, 0, 0, 2]
    meanings = " ".join([*NAMES, "not_finite"])
    return xr.Dataset(
        {"outcome": (("scheme", "problem", "amplitude", "dt_over_period"), outcome, {"flag_meanings": meanings})},
        coords={
            "scheme": ["own"],
            "scheme_title": ("scheme", ["Own"]),
            "family": ("scheme", ["Own"]),
            "problem": ["hardening", "softening"],
            "amplitude": [0.1, 1.0, 2.0],
            "dt_over_period": [0.01, 0.1, 0.2, 0.5],
        },
    )


def test_boundaries():
    near = near_1996(atlas())
    assert near.amplitude.values.tolist() == [1.0, 2.0]
    # accurate again beyond a step that is not does not count
    assert accurate_up_to(near).sel(scheme="own").values.tolist() == [0.01, 0.2]
    assert first_of(near, "chaotic").sel(scheme="own").values.tolist() == [0.5, np.inf]
    assert np.isinf(first_of(near, "growing")).all()


def test_the_table_names_the_spring_that_comes_first():
    (row,) = tabulate(atlas()).to_dict("records")
    assert row["1 % up to"] == "0.01 (h)" and row["Chaotic"] == "0.5 (h)" and row["Damped to rest"] == "0.5 (s)"
    assert row["Growing"] == row["Not finite"] == "–" and row["Newton fails"] == "0.5 (h)"
