"""Numbers on the rule that sets the step size by the highest frequency."""

import numpy as np
import xarray as xr

from paper.numbers.step_rule import SCHEMES, step_rule_numbers

STEPS = [0.01, 0.02, 0.05, 0.1]


def _rule(largest):
    """Runs on two springs.

    ``largest`` is the largest safe Δt ωmax of each scheme on the first spring; on the second it is twice as large.
    """
    upto = np.multiply.outer(list(largest.values()), [1.0, 2.0])[..., None, None]
    errors = np.repeat(np.where(np.array(STEPS) <= upto, 0.005, 0.02), 2, axis=2)
    dims = ("scheme", "problem", "amplitude", "omega_step")
    return xr.Dataset(
        {"max_energy_error": (dims, errors), "period_error": (dims, errors)},
        {
            "scheme": list(largest),
            "scheme_title": ("scheme", [name.title() for name in largest]),
            "omega_step": STEPS,
            "periods": 100,
            "amplitude": [0.5, 0.6],
            "period": (("problem", "amplitude"), np.full((2, 2), 2.0)),
            "highest_frequency": (("problem", "amplitude"), [[0.5, 0.5], [2.0, 2.0]]),
        },
    )


def test_ranges_are_those_of_the_runs():
    numbers = step_rule_numbers(_rule({**dict.fromkeys(SCHEMES, 0.05), "rk4": 0.01}))
    assert (numbers["rule_below_central_difference"], numbers["rule_most_central_difference"]) == ("0.05", "0.10")
    # T ωmax of the springs is 1 and 4
    assert numbers["rule_steps_central_difference"] == "20 to 40"
    assert (numbers["rule_below_rk4"], numbers["rule_most_rk4"]) == ("0.01", "0.02")
    assert numbers["rule_steps_rk4"] == "100 to 200"
    assert not numbers["rule_serves"]  # Δt ωmax varies as much as the number of steps in a period
    assert numbers["rule_exceptions"] == "none"


def test_an_amplitude_that_allows_more_than_its_neighbours_does_not_count():
    rule = _rule(dict.fromkeys(SCHEMES, 0.02))
    rule["max_energy_error"][0, 1, 0] = rule["period_error"][0, 1, 0] = 0.005
    assert step_rule_numbers(rule)["rule_most_central_difference"] == "0.02"


def test_a_step_does_not_count_where_a_finer_one_fails():
    rule = _rule(dict.fromkeys(SCHEMES, 0.05))
    rule["max_energy_error"][0, 0, 0, 1] = 0.02
    numbers = step_rule_numbers(rule)
    assert numbers["rule_below_central_difference"] == "0.01" and numbers["rule_below_rk4"] == "0.05"
    assert numbers["rule_exceptions"] == "Central Difference"


def test_a_scheme_that_no_step_serves_is_an_exception():
    rule = _rule({**dict.fromkeys(SCHEMES, 0.05), "own": 0.05})
    rule["period_error"][-1, 0] = np.nan
    numbers = step_rule_numbers(rule)
    assert numbers["rule_exceptions"] == "Own"
