"""What the table of enough steps reads off its dataset."""

import numpy as np
import xarray as xr

from paper.tables.robustness import tabulate


def test_the_longest_runs_count_and_the_most_steps_stand_for_failure():
    needed = np.array([[[20.0, 40.0], [10.0, np.nan]]])  # one problem: levels, then lengths of runs
    robustness = xr.Dataset(
        {
            "steps_needed": (("problem", "scheme", "level", "periods"), needed[:, None]),
            "most_steps": ((), 256),
        },
        coords={
            "problem": ["softening"],
            "problem_title": ("problem", ["softening spring"]),
            "scheme": ["own"],
            "scheme_title": ("scheme", ["Own"]),
            "level": [5, 1],
            "periods": [10, 100],
        },
    )
    (row,) = tabulate(robustness).to_dict("records")
    assert row == {"Scheme": "Own", "Softening 5 %": "40", "Softening 1 %": "> 256"}
