"""Claims on problems whose solution is known: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import published_numbers as claims
from tests.paper.claims.made_up import filled

SCHEMES = ["average_acceleration", "central_difference"]


def _errors(error):
    """A dataset like published_numbers.nc, in which ``error`` gives the errors of both schemes by refinement."""
    along = {"problem": ["van_der_pol", "loaded_bar"], "scheme": SCHEMES, "refinement": [0, 1, 2]}
    data = filled(1.0, **along).to_dataset(name="error")
    data["error"][:] = error
    data["steps"] = ("problem", "refinement"), [[20_000, 200_000, 2_000_000], [32, 128, 512]]
    data["time"] = "problem", [2.0, 2.0]
    return data.assign_coords(explicit=("scheme", [0, 1]))


def test_central_difference_is_exact_or_not():
    found = claims.exact_on_a_bar(_errors([np.nan, 0.0, 1e-3]))
    assert found.holds and found.ours == "0 at 128"
    missed = claims.exact_on_a_bar(_errors([np.nan, 1e-3, 1e-4]))
    assert not missed.holds and missed.qualification
    assert not claims.exact_on_a_bar(_errors(np.nan)).holds


def test_control_needs_fewer_steps_or_not():
    data = _errors([1.0, 1e-3, 1e-4]).assign_coords(problem=["arenstorf", "other"], scheme=["rk4", "bathe"])
    along = {"problem": data.problem.values, "scheme": data.scheme.values, "tolerance": [1e-3, 1e-5]}
    data["controlled_error"], data["controlled_steps"] = filled(1e-3, **along), filled(100.0, **along)
    assert claims.fewer_controlled_steps(data).ours == "2000"
    assert claims.fewer_controlled_steps(data).holds
    never = data.assign(error=data.error + 1)
    assert claims.fewer_controlled_steps(never).holds and claims.fewer_controlled_steps(never).qualification
    data["controlled_steps"][:] = 1e5
    late = claims.fewer_controlled_steps(data)
    assert not late.holds and late.qualification
    data["controlled_error"][:] = np.nan
    without = claims.fewer_controlled_steps(data)
    assert not without.holds and without.qualification


def test_the_step_of_an_implicit_scheme_is_bound_or_not():
    found = claims.beyond_the_fastest_time(_errors([np.nan, 1.0, 1e-3]))
    assert not found.holds and found.ours == "1" and found.qualification
    found = claims.beyond_the_fastest_time(_errors([1e-2, 1e-3, 1e-4]))
    assert found.holds
    assert not claims.beyond_the_fastest_time(_errors(np.nan)).holds


def _ueda(exponents):
    """A dataset like ueda.nc, with the given exponents by number of steps for both schemes."""
    data = filled(0.0, scheme=SCHEMES, steps_per_period=[16, 32, 64]).to_dataset(name="exponent")
    data["exponent"][:] = exponents
    data["printed_exponent"] = xr.DataArray(0.1)
    return data


def test_twenty_steps_keep_chaos_or_not():
    assert claims.twenty_steps_keep_chaos(_ueda([0.1, 0.1, 0.1])).holds
    late = claims.twenty_steps_keep_chaos(_ueda([0.1, -0.02, 0.105]))
    assert not late.holds and "64" in late.ours and "regular" in late.qualification
    assert claims.fewest_steps(_ueda([0.1, -0.02, 0.105])) == dict.fromkeys(SCHEMES, 64.0)
    assert not claims.twenty_steps_keep_chaos(_ueda(np.nan)).holds


@pytest.mark.parametrize("order, holds", [(2, True), (1, False)])
def test_statistics_converge_or_not(order, holds):
    steps = np.array([24, 32, 48, 64])
    data = filled(0.1, scheme=["rk4", *claims.FAITHFUL], steps_per_period=steps).to_dataset(name="exponent")
    data["mean_square"] = 2.5 + (data.scheme != "rk4") * 10.0 / data.steps_per_period**order
    data["mean_square_uncertainty"] = xr.full_like(data.exponent, 1e-6)
    data.coords["scheme_title"] = data.scheme
    finding = claims.statistics_converge(data)
    assert finding.holds == holds and f"{order:.1f} ± 0.0" in finding.ours
    data["exponent"][1, :2] = -0.1  # regular motion does not count, and two steps are not enough
    assert np.isnan(claims.orders_of_means(data)[claims.FAITHFUL[0]]).all()


def test_a_run_that_is_accurate_by_accident_does_not_count():
    """Of runs with 1, 2, 4 and 8 steps the first and the last are accurate: only the last one counts."""
    orbit = xr.Dataset(
        {
            "error": (("problem", "scheme", "refinement"), [[[0.001, 1.59, 0.4, 0.007]]]),
            "steps": (("problem", "refinement"), [[1, 2, 4, 8]]),
            "controlled_error": (("problem", "scheme", "tolerance"), [[[0.001, 0.5]]]),
            "controlled_steps": (("problem", "scheme", "tolerance"), [[[3.0, 9.0]]]),
        },
        {"problem": ["arenstorf"], "scheme": ["rk4"]},
    )
    steps = claims.steps_of_orbit(orbit)
    assert steps["equal"] == {"rk4": 8} and np.isnan(steps["controlled"]["rk4"])
