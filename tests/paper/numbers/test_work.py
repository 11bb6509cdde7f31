"""The fastest scheme for an exacting error."""

import numpy as np
import xarray as xr

from paper.numbers.work import DISPLACED, _further_runs, _starts, fastest, longer_run_numbers
from study.runs.needs import decisions, joined_needs, needs
from tests.runs.made_up import runs, with_kinds


def test_a_run_that_is_exact_by_accident_is_no_fastest_run():
    """The error of the quick scheme at its second step is small by cancellation."""
    coords = {"scheme": ["quick", "steady"], "steps_per_period": [8, 16, 32]}
    error = xr.DataArray([[1e-3, 1e-12, 1e-8], [1e-9, 5e-11, 1e-12]], coords)
    time = xr.DataArray([[1e-3, 2e-3, 4e-3], [2e-3, 5e-3, 9e-3]], coords)
    assert fastest(error, time, "scheme", "steps_per_period") == ("steady", 5.0)
    assert np.isnan(fastest(error.sel(scheme=["quick"]), time.sel(scheme=["quick"]), "scheme", "steps_per_period")[1])


def test_further_starts_are_counted_without_the_own_one():
    known = {
        "starts": ("problem", [21, 61, 3, 4]),
        "spacing": ("problem", [np.nan, np.nan, np.nan, 0.02]),
        "has_kinks": ("problem", [1, 1, 0, 0]),
        "problem_title": ("problem", ["yielding oscillator", "bouncing mass", "chain", "shaken oscillator"]),
    }
    decisions = xr.Dataset(coords=known | {"problem": ["yielding", "bouncing", "chain", "shaken"]})
    assert _starts(decisions) == {
        "kinked_starts": "20 of the yielding oscillator and 60 of the bouncing mass",
        "other_starts": "2",
    }
    assert _starts(decisions.sel(problem=["shaken"])) == {"kinked_starts": None, "other_starts": None}


def test_steps_next_to_whole_parts_of_the_period_and_further_durations():
    # 39.9 is no neighbour of a whole number, 41 is one by round-off, 42.0042 was proposed, 45.0004 is one by accident
    known = {"steps_per_period": ("size", [39.9, 41 + 1e-13, 40.004, 42.0042, 43.0043, 45.0004])}
    known["proposed"] = ("size", [0, 0, 0, 1, 0, 0])
    runs = xr.Dataset(coords=known | {"periods": [50.0, 100.0, 150.0], "decided": 100})
    assert _further_runs(runs) == {"beside": "0.01", "longer_durations": "150"}
    assert _further_runs(runs.isel(size=[0, 1]))["beside"] is None


def test_a_longer_run_decides_a_step_of_the_usual_scheme_or_of_a_chosen_one():
    """Over twice the duration the error may be four times the allowed one."""
    lasting, accidental = [0.2, 0.008, 0.005, 0.002], [0.2, 0.05, 0.02, 0.008]

    def longer(usual, chosen):
        parts = [runs([lasting] * 3, problem="softening"), runs([usual, chosen, lasting], problem="softening")]
        parts[1] = parts[1].assign_coords(periods=[20.0], duration=("periods", [40.0]))
        ds = xr.concat(parts, "periods", data_vars="minimal")
        ds = ds.assign_coords(scheme=["average_acceleration", "dear", "stiff"])
        decided = decisions(with_kinds(joined_needs([needs(ds, [0.01])])))
        return longer_run_numbers(decided, [ds if name == "softening" else None for name in DISPLACED])

    model = "free vibration over a long time"
    assert longer(lasting, lasting) == {"models_longer": None}
    assert longer(accidental, lasting) == {"models_longer": model}
    assert longer(lasting, accidental) == {"models_longer": model}
