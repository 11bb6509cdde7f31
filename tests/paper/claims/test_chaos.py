"""Claims on chaotic motions: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import chaos as claims
from tests.paper.claims.made_up import filled

SCHEMES = ["rk4", *claims.FAITHFUL]


def _chaos(exponents=0.1, steps=(16, 32, 64)):
    """A dataset like chaos.nc, with the given largest exponents by number of steps."""
    along = {"problem": ["ueda"], "scheme": SCHEMES, "steps_per_period": list(steps), "place": [0, 1]}
    data = filled(0.0, **along).to_dataset(name="exponent")
    data["exponent"][..., 0] = exponents
    data["regular"] = (data.exponent.isel(place=0) < 0).astype(float)
    data["contraction"] = 0.05 * xr.ones_like(data.regular)
    data["printed_exponent"], data["damping"] = ("problem", [0.1]), ("problem", [0.05])
    return data.assign_coords(scheme_title=data.scheme, problem_title=data.problem)


def test_twenty_steps_keep_chaos_or_not():
    assert claims.twenty_steps_keep_chaos(_chaos()).holds
    late = claims.twenty_steps_keep_chaos(_chaos([0.1, -0.02, 0.105]))
    assert not late.holds and "64" in late.ours and "regular" in late.qualification
    assert claims.fewest_steps(_chaos([0.1, -0.02, 0.105])) == dict.fromkeys(SCHEMES, 64.0)
    assert not claims.twenty_steps_keep_chaos(_chaos(np.nan)).holds


@pytest.mark.parametrize("order, holds", [(2, True), (1, False)])
def test_statistics_converge_or_not(order, holds):
    data = _chaos(steps=(24, 32, 48, 64))
    data["mean_square"] = 2.5 + (data.scheme != "rk4") * 10.0 / data.steps_per_period**order + 0 * data.regular
    data["mean_square_uncertainty"] = xr.full_like(data.regular, 1e-6)
    finding = claims.statistics_converge(data)
    assert finding.holds == holds and f"{order:.1f} ± 0.0" in finding.ours
    data["regular"][0, 1, :2] = 0.5  # a step with regular runs does not count, and two steps are not enough
    assert np.isnan(claims.orders_of_means(data)[SCHEMES[1]]).all()


def test_the_interval_of_an_order_holds_the_noise_of_the_shared_reference():
    random, steps, errors = np.random.default_rng(1), np.array([24, 32, 48, 64]), np.array([2.0, 2.0, 2.0, 2.0]) * 1e-4
    shared, exact = 4e-4, 10.0 / steps**2.0
    found = [
        claims._power(steps, exact + errors * random.normal(size=4) + shared * random.normal(), errors**2, shared**2)
        for _ in range(400)
    ]
    covered = np.mean([abs(order - 2) < half for order, half in found])
    assert 0.95 < covered and np.median([half for _, half in found]) < 1


def test_the_interval_of_an_order_holds_the_bend_of_coarse_steps():
    steps = np.array([40, 44, 52, 64, 96, 128])
    order, half = claims._power(steps, 10 / steps**2.0 + 3e7 / steps**6.0, np.full(6, 1e-10), 1e-10)
    assert order > 2.1 and half > 0.1


@pytest.mark.parametrize("order, half, second", [(2.2, 0.1, True), (2.4, 0.5, True), (2.4, 0.1, False), (2, 3, False)])
def test_second_order_needs_an_interval_without_first_and_third(order, half, second):
    assert claims.is_second(order, half) == second


def test_exponents_add_up_or_numerical_damping_adds_to_them():
    data = _chaos()
    assert claims.exponents_add_up(data).holds
    data["contraction"][0, 1, -1] = 0.1
    found = claims.exponents_add_up(data)
    assert not found.holds and found.qualification == f"numerical damping adds to it with {SCHEMES[1]}"
    assert "2.00" in found.ours


def test_finer_steps_keep_chaos_or_not():
    assert claims.finer_steps_keep_chaos(_chaos([-0.1, 0.1, 0.1])).holds
    lost = claims.finer_steps_keep_chaos(_chaos([0.1, -0.1, 0.1]))
    assert not lost.holds and lost.ours.count("on ueda") == 3
