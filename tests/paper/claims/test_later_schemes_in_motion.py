"""Claims on later schemes in motion: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import later_schemes_in_motion as claims
from tests.paper.claims.made_up import filled

MEMBERS = ["gautschi", "deuflhard", "garcia_archilla"]
WAVES = ["rho_bathe", "beta_bathe", "noh_bathe", "central_difference"]
FOURTH = ["blanes_moan4", "mclachlan4"]


def _later(**parts):
    """A dataset like later_schemes.nc: all values are one, except values given for a variable or for its schemes."""
    along = {
        "largest_stiffening": {"with_model": ["chen_ricles", "chang", "kr_alpha"], "omega_step": [1.0, 10.0]},
        "trigonometric_end_error": {"member": MEMBERS, "steps": [16, 32, 64]},
        "wave_error": {"wave_scheme": WAVES, "courant": [0.5, 1.0]},
        "auxiliary_error": {"auxiliary": ["auxiliary_variable", "average_acceleration"], "steps": [16, 32, 64]},
        "auxiliary_peak": {"step_size": [0.5, 8.0]},
        "fourth_order_error": {"fourth_order_scheme": FOURTH, "force_evaluations": [192, 384]},
    }
    data = xr.Dataset({name: filled(1.0, **dims) for name, dims in along.items()})
    for name, values in parts.items():
        if not isinstance(values, dict):
            data[name][:] = values
            continue
        first = data[name].dims[0]
        for label, value in values.items():
            data[name].loc[{first: label}] = value
    return data


def _reality(scheme, **orders):
    """A dataset like order_under_reality.nc, with orders of four, except orders given by circumstance or quantity."""
    along = {
        "scheme": [scheme],
        "circumstance": ["plain", "damping", "load", "support_0"],
        "quantity": ["displacement", "velocity", "acceleration"],
    }
    data = filled(4.0, **along)
    for name, value in orders.items():
        data.loc[{"circumstance" if name in along["circumstance"] else "quantity": name}] = value
    return data.to_dataset(name="observed_order")


def _spectral(**powers):
    """A dataset like spectral.nc, with the given power of growth of u from v for each scheme; other powers are zero."""
    names = [f"growth_{variable}_from_{start}" for variable in "uv" for start in "uv"]
    along = {"scheme": list(powers), "damping_ratio": [0.0]}
    data = xr.Dataset({name: filled(0.0, **along) for name in [*names, "linear_order"]})
    for scheme, power in powers.items():
        data.growth_u_from_v.loc[{"scheme": scheme}] = power
    return data


@pytest.mark.parametrize(
    "check, scheme",
    [
        (claims.cr_on_stiffening, "chen_ricles"),
        (claims.chang_on_stiffening, "chang"),
        (claims.kr_on_stiffening, "kr_alpha"),
    ],
)
def test_a_model_bounds_the_tangent(check, scheme):
    bounded = check(_later(largest_stiffening={scheme: [5.0, 1.04]}))
    assert not bounded.holds and "4.0 M/Δt²" in bounded.qualification
    assert check(_later(largest_stiffening={scheme: [1e4, 1e4]})).holds


@pytest.mark.parametrize("check, scheme", [(claims.order_of_cr, "chen_ricles"), (claims.order_of_mkr, "mkr_alpha")])
@pytest.mark.parametrize(
    "first, lagged, holds, qualified", [(2, 2, True, False), (1, 2, True, True), (1, 1, False, True)]
)
def test_order_of_a_scheme_whose_velocity_lags(check, scheme, first, lagged, holds, qualified):
    errors = [[[1.0, 0.5**order] for order in (first, lagged)]]
    data = xr.Dataset(
        {"lag_error": (("lagging", "lagged_start", "many_steps"), errors)},
        {"lagging": [scheme], "lagged_start": ["initial velocity", "lagged velocity"], "many_steps": [1, 2]},
    )
    finding = check(data)
    assert finding.holds == holds and bool(finding.qualification) == qualified


@pytest.mark.parametrize(
    "check, powers, holds",
    [
        (claims.same_power_of_overshoot, {"kr_alpha": 1, "mkr_alpha": 1}, True),
        (claims.same_power_of_overshoot, {"kr_alpha": 1, "mkr_alpha": 0}, False),
        (claims.no_overshoot_of_two_steps, {"oalts": 0, "generalized_alpha": 1}, True),
        (claims.no_overshoot_of_two_steps, {"oalts": 1, "generalized_alpha": 1}, False),
        (claims.no_overshoot_of_two_steps, {"oalts": 0, "generalized_alpha": 0}, False),
        (claims.overshoot_with_a_model, {"chang": 0, "chen_ricles": 1, "kr_alpha": 1}, True),
        (claims.overshoot_with_a_model, {"chang": 1, "chen_ricles": 1, "kr_alpha": 1}, False),
    ],
)
def test_powers_of_overshoot(check, powers, holds):
    assert check(_spectral(**powers)).holds == holds


@pytest.mark.parametrize(
    "check, scheme",
    [(claims.third_order_in_motion, "wat2"), (claims.second_order_of_generalized_alpha, "generalized_alpha")],
)
def test_orders_of_motion_and_acceleration(check, scheme):
    for orders, holds, qualified in (
        ({}, True, False),
        ({"acceleration": 1.0}, True, True),
        ({"damping": 1.0}, False, True),
    ):
        finding = check(_reality(scheme, **orders))
        assert (finding.holds, bool(finding.qualification)) == (holds, qualified)
    assert not check(_reality(scheme, load=np.nan)).holds


@pytest.mark.parametrize("order, holds", [(4.0, False), (2.0, True)])
def test_loose_tolerances_cost_the_order_or_not(order, holds):
    plain = _reality("average_acceleration")
    early = (plain * 0 + order).isel(circumstance=[0]).assign_coords(circumstance=["tolerance_0"])
    finding = claims.order_with_loose_tolerances(xr.concat([plain, early], "circumstance"))
    assert finding.holds == holds and bool(finding.qualification) != holds


def test_reduction_by_a_load_and_by_a_support():
    for orders, holds, qualified in (
        ({}, True, False),
        ({"support_0": np.nan}, True, True),
        ({"load": 3.0}, False, False),
    ):
        finding = claims.no_reduction_under_a_load(_reality("esdirk4", **orders))
        assert (finding.holds, bool(finding.qualification)) == (holds, qualified)


@pytest.mark.parametrize(
    "peak, ratio, holds, qualified",
    [(2.0, 1.0, True, False), (2.0, 3.0, True, True), (99.0, 1.0, False, False), (np.nan, 1.0, False, False)],
)
def test_bounds_by_an_auxiliary_variable(peak, ratio, holds, qualified):
    data = _later(auxiliary_peak=[1.0, peak], auxiliary_error={"auxiliary_variable": ratio})
    finding = claims.bounded_by_an_auxiliary_variable(data)
    assert (finding.holds, bool(finding.qualification)) == (holds, qualified)


@pytest.mark.parametrize("order, holds", [(2.0, True), (1.0, False)])
def test_order_with_an_auxiliary_variable(order, holds):
    data = _later(auxiliary_error={"auxiliary_variable": np.array([16.0, 32.0, 64.0]) ** -order})
    assert claims.order_with_an_auxiliary_variable(data).holds == holds


def test_errors_over_all_frequencies():
    uniform, erratic = np.array([16.0, 32.0, 64.0]) ** -2, np.array([1.0, 1.0, 0.01])
    for member, check in (
        ("gautschi", claims.uniform_error_of_gautschi),
        ("garcia_archilla", claims.uniform_error_of_mollified_impulse),
    ):
        assert check(_later(trigonometric_end_error={member: uniform})).holds
        assert not check(_later(trigonometric_end_error={member: erratic})).holds
    cured = {"deuflhard": erratic, "garcia_archilla": uniform}
    assert claims.resonances_of_impulse(_later(trigonometric_end_error=cured)).holds
    assert not claims.resonances_of_impulse(_later(trigonometric_end_error=cured | {"deuflhard": uniform})).holds


@pytest.mark.parametrize(
    "check, scheme",
    [(claims.better_for_waves, "beta_bathe"), (claims.better_for_waves_than_central_difference, "noh_bathe")],
)
def test_waves(check, scheme):
    better = check(_later(wave_error={scheme: 0.8}))
    assert better.holds and not better.qualification
    assert not check(_later(wave_error={scheme: 1.2})).holds
    assert check(_later(wave_error={scheme: 0.8, "central_difference": [1.0, 0.1]})).qualification


@pytest.mark.parametrize("error, holds", [(0.5, True), (2.0, False)])
def test_errors_at_equal_cost(error, holds):
    finding = claims.least_error_of_fourth_order(_later(fourth_order_error={"blanes_moan4": error}))
    assert finding.holds == holds and bool(finding.qualification) != holds


def _relaxation(plain, relaxed):
    along = {"problem": ["hardening"], "steps_per_period": [20, 100, 200], "variant": ["plain", "relaxed"]}
    data = filled(1.0, **along)
    for variant, values in (("plain", plain), ("relaxed", relaxed)):
        data.loc[{"variant": variant}] = values
    return data.to_dataset(name="return_error")


def test_relaxation_in_motion():
    fourth_order, second_order = 1.0 / np.array([20, 100, 200.0]) ** 4, 1.0 / np.array([20, 100, 200.0]) ** 2
    assert claims.order_with_relaxation(_relaxation(1.0, fourth_order)).holds
    assert not claims.order_with_relaxation(_relaxation(1.0, second_order)).holds
    assert not claims.motion_with_relaxation(_relaxation(1.0, 2.0)).holds
    everywhere, mostly = (claims.motion_with_relaxation(_relaxation(1.0, error)) for error in (0.5, [2.0, 0.5, 0.5]))
    assert everywhere.holds and not everywhere.qualification and mostly.holds and mostly.qualification
