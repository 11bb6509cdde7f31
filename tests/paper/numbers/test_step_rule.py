"""Numbers on the step by the highest frequency."""

import numpy as np
import xarray as xr

from paper.numbers.step_rule import SCHEMES, of_step_rule

STEPS = [0.01, 0.02, 0.05, 0.1]


def _maps(largest):
    """Maps of schemes whose runs are safe up to a Δt ωmax, on two springs of the stiffness 1 and 4."""
    by_frequency = np.multiply.outer([1.0, 4.0], STEPS)[None, :, None] + np.zeros((len(largest), 1, 1, 1))
    dims = ("scheme", "problem", "amplitude", "dt_over_period")
    errors = np.where(by_frequency <= np.reshape(list(largest.values()), (-1, 1, 1, 1)), 0.5, 2.0)
    return xr.Dataset(
        {"max_energy_error": (dims, errors), "period_error": (dims, errors / 100)},
        {
            "scheme": list(largest),
            "scheme_title": ("scheme", [name.title() for name in largest]),
            "dt_over_period": STEPS,
            "period": (("problem", "amplitude"), np.full((2, 1), 2.0)),
            "highest_frequency": (("problem", "amplitude"), [[0.5], [2.0]]),
        },
    )


def test_ranges_are_those_of_the_runs():
    found = of_step_rule(_maps({**dict.fromkeys(SCHEMES, 0.05), "rk4": 0.03}))
    # the first unsafe runs have 0.08 and 0.04; the largest safe steps of rk4 are 0.02 and, on the stiff spring, none
    assert (found["rule_below_central_difference"], found["rule_most_central_difference"]) == ("0.08", "0.05")
    assert found["rule_steps_central_difference"] == "20 to 100"
    assert (found["rule_below_rk4"], found["rule_most_rk4"]) == ("0.04", "0.02")
    assert found["rule_steps_rk4"] == "50 to more than 100"
    assert found["rule_tested"] == "50" and found["rule_serves"] and found["rule_exceptions"] == "none"


def test_a_scheme_that_another_quantity_limits_is_an_exception():
    maps = _maps({**dict.fromkeys(SCHEMES, 0.05), "own": 0.4})
    maps["period_error"][-1, 0, 0, -2:] = 0.03
    assert of_step_rule(maps)["rule_exceptions"] == "Own"
