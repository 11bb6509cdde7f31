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
    data = filled(0.0, **along).to_dataset(name="lyapunov_exponent")
    data["lyapunov_exponent"][..., 0] = exponents
    data["regular"] = (data.lyapunov_exponent.isel(place=0) < 0).astype(float)
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


@pytest.mark.parametrize("order, holds", [(2, True), (1, False)])
def test_other_statistics_converge_or_not(order, holds):
    data = _chaos(steps=(24, 32, 48, 64))
    data["mean_square"] = 2.5 + (data.scheme != "rk4") * 10.0 / data.steps_per_period**order + 0 * data.regular
    data["mean_square_uncertainty"] = xr.full_like(data.regular, 1e-6)
    finding = claims.other_statistics_converge(data.assign_coords(problem=["beam"]))
    assert finding.holds == holds and f"ueda, average_acceleration: {order:.1f} ± 0.0" in finding.ours
    nothing = claims.other_statistics_converge(data)  # Ueda's oscillator alone
    assert not nothing.holds and nothing.ours == "none"


def test_the_steps_of_a_mean_count_its_uncertainty():
    data = _chaos(steps=(16, 32, 64))
    error = (data.scheme != "rk4") * xr.DataArray([0.02, 0.009, 0.0], dims="steps_per_period") + 0 * data.regular
    data["mean_square"] = 2.5 * (1 + error)
    data["mean_square_uncertainty"] = xr.full_like(data.regular, 1e-6)
    assert claims.fewest_steps_of_mean(data, 0.01) == {"rk4": 16, **dict.fromkeys(claims.FAITHFUL, 32)}
    data["mean_square_uncertainty"] += 2.5 * 0.0004  # 0.9 % and twice √2 · 0.04 % are more than 1 %
    assert claims.fewest_steps_of_mean(data, 0.01) == {"rk4": 16, **dict.fromkeys(claims.FAITHFUL, 64)}


@pytest.mark.slow
@pytest.mark.parametrize("shared, scatter", [(4e-4, 0.0), (1e-5, 0.1)])
def test_the_interval_of_an_order_covers_it(shared, scatter):
    random, steps, error = np.random.default_rng(1), np.array([24, 32, 40, 48, 64]), 2e-4

    def drawn():
        exact = 10.0 / steps**2.0 * np.exp(scatter * random.normal(size=5))
        measured = exact + error * random.normal(size=5) + shared * random.normal()
        return claims._power(steps, measured, np.full(5, error**2), shared**2)

    orders, halves = np.array([drawn() for _ in range(100)]).T
    assert np.mean(abs(orders - 2) < halves) > 0.9 and np.median(halves) < 1
    assert np.mean(orders) == pytest.approx(2, abs=0.05)


@pytest.mark.parametrize("order, half, second", [(2.2, 0.1, True), (2.4, 0.5, True), (2.4, 0.1, False), (2, 3, False)])
def test_second_order_needs_an_interval_without_first_and_third(order, half, second):
    assert claims.is_second(order, half) == second


def test_exponents_add_up_or_numerical_damping_adds_to_them():
    data = _chaos()
    assert claims.exponents_add_up(data).holds
    data["contraction"][0, 1, -1] = 0.1
    finding = claims.exponents_add_up(data)
    assert not finding.holds and finding.qualification == f"numerical damping adds to it with {SCHEMES[1]}"
    assert "2.00" in finding.ours


def test_finer_steps_keep_chaos_or_not():
    assert claims.finer_steps_keep_chaos(_chaos([-0.1, 0.1, 0.1])).holds
    lost = claims.finer_steps_keep_chaos(_chaos([0.1, -0.1, 0.1]))
    assert not lost.holds and lost.ours.count("on ueda") == 3
