"""Claims on problems whose solution is known: each check is tested where it holds and where it fails."""

import numpy as np
import xarray as xr

from paper.claims import published_numbers as claims
from tests.paper.claims.made_up import filled

SCHEMES = ["average_acceleration", "central_difference"]


def _errors(error):
    """A dataset like published_numbers.nc, in which ``error`` gives the errors of both schemes by refinement."""
    along = {"problem": ["van_der_pol", "loaded_bar"], "scheme": SCHEMES, "refinement": [0, 1, 2]}
    data = filled(1.0, **along).to_dataset(name="end_error")
    data["end_error"][:] = error
    data["steps"] = ("problem", "refinement"), [[20_000, 200_000, 2_000_000], [32, 128, 512]]
    data["duration"] = "problem", [2.0, 2.0]
    return data.assign_coords(explicit=("scheme", [0, 1]))


def test_central_difference_is_exact_or_not():
    finding = claims.exact_on_a_bar(_errors([np.nan, 0.0, 1e-3]))
    assert finding.holds and finding.ours == "0 at 128"
    missed = claims.exact_on_a_bar(_errors([np.nan, 1e-3, 1e-4]))
    assert not missed.holds and missed.qualification
    assert not claims.exact_on_a_bar(_errors(np.nan)).holds


def test_control_needs_fewer_steps_or_not():
    data = _errors([1.0, 1e-3, 1e-4]).assign_coords(problem=["arenstorf", "other"], scheme=["rk4", "bathe"])
    along = {"problem": data.problem.values, "scheme": data.scheme.values, "tolerance": [1e-3, 1e-5]}
    data["controlled_end_error"], data["controlled_steps"] = filled(1e-3, **along), filled(100.0, **along)
    assert claims.fewer_controlled_steps(data).ours == "2000"
    assert claims.fewer_controlled_steps(data).holds
    never = data.assign(end_error=data.end_error + 1)
    assert claims.fewer_controlled_steps(never).holds and claims.fewer_controlled_steps(never).qualification
    data["controlled_steps"][:] = 1e5
    late = claims.fewer_controlled_steps(data)
    assert not late.holds and late.qualification
    data["controlled_end_error"][:] = np.nan
    without = claims.fewer_controlled_steps(data)
    assert not without.holds and without.qualification


def test_the_step_of_an_implicit_scheme_is_bound_or_not():
    finding = claims.beyond_the_fastest_time(_errors([np.nan, 1.0, 1e-3]))
    assert not finding.holds and finding.ours == "1" and finding.qualification
    finding = claims.beyond_the_fastest_time(_errors([1e-2, 1e-3, 1e-4]))
    assert finding.holds
    assert not claims.beyond_the_fastest_time(_errors(np.nan)).holds


def test_a_run_that_is_accurate_by_accident_does_not_count():
    """Of runs with 1, 2, 4 and 8 steps the first and the last are accurate: only the last one counts."""
    orbit = xr.Dataset(
        {
            "end_error": (("problem", "scheme", "refinement"), [[[0.001, 1.59, 0.4, 0.007]]]),
            "steps": (("problem", "refinement"), [[1, 2, 4, 8]]),
            "controlled_end_error": (("problem", "scheme", "tolerance"), [[[0.001, 0.5]]]),
            "controlled_steps": (("problem", "scheme", "tolerance"), [[[3.0, 9.0]]]),
        },
        {"problem": ["arenstorf"], "scheme": ["rk4"]},
    )
    steps = claims.steps_of_orbit(orbit)
    assert steps["equal"] == {"rk4": 8} and np.isnan(steps["controlled"]["rk4"])
