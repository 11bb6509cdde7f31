"""Claims of the authors of later schemes: each check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import later_schemes
from tests.paper.claims.made_up import filled

SCHEMES = [
    "generalized_alpha",
    "oalts",
    "kr_alpha",
    "mkr_alpha",
    "chen_ricles",
    "chang",
    "icl",
    "wat2",
    "esdirk3",
    "esdirk4",
]


def _spectral(variables):
    """A dataset like spectral.nc: all values are one, except the values given by variable and scheme."""
    names = ["linear_order", "stability_limit", "infinite_frequency_radius"]
    over_steps = ["algorithmic_damping", "displacement_overshoot", "period_elongation"]
    along = {"scheme": SCHEMES, "damping_ratio": [0.0, 0.1]}
    data = filled(1.0, **along).to_dataset(name="memory").assign({name: filled(1.0, **along) for name in names})
    data = data.assign({name: filled(1.0, **along, step_size_over_period=[0.01, 0.1]) for name in over_steps})
    for name, values in variables.items():
        for scheme, value in values.items():
            data[name].loc[{"scheme": scheme}] = value
    return data


@pytest.mark.parametrize("part, holds", [(0.5, True), (0.56, False), (0.44, False)])
def test_half_the_damping(part, holds):
    finding = later_schemes.half_the_damping(_spectral({"algorithmic_damping": {"oalts": part}}))
    assert (finding.ours, finding.holds) == (f"{part:.2f}", holds)


@pytest.mark.parametrize("overshoot, price, holds, qualified", [(0.9, 1.0, True, False), (1.1, 2.0, False, True)])
def test_less_overshoot_has_a_price(overshoot, price, holds, qualified):
    spectral = _spectral(
        {"displacement_overshoot": {"mkr_alpha": overshoot}, "period_elongation": {"mkr_alpha": price}}
    )
    finding = later_schemes.less_overshoot(spectral)
    assert (finding.holds, bool(finding.qualification)) == (holds, qualified)


@pytest.mark.parametrize("limit, overshoot, holds", [(np.inf, 0.0, True), (np.inf, 128.0, True), (2.0, 0.0, False)])
def test_stability_with_a_model(limit, overshoot, holds):
    spectral = _spectral(
        {"stability_limit": {"chen_ricles": limit}, "displacement_overshoot": {"chen_ricles": overshoot}}
    )
    finding = later_schemes.stable_with_a_model(spectral)
    assert (finding.holds, bool(finding.qualification)) == (holds, overshoot > 1)


@pytest.mark.parametrize("limit, order, holds", [(np.inf, 2.0, True), (np.inf, 1.0, False), (2.0, 2.0, False)])
def test_second_order_with_a_model(limit, order, holds):
    spectral = _spectral({"stability_limit": {"chang": limit}, "linear_order": {"chang": order}})
    assert later_schemes.second_order_with_a_model(spectral).holds == holds


@pytest.mark.parametrize(
    "order, limits, holds", [(2.0, [1.9, 1.9], True), (1.0, [1.9, 1.9], False), (2.0, [1.9, 1.5], True)]
)
def test_second_order_with_one_force(order, limits, holds):
    finding = later_schemes.second_order_with_one_force(
        _spectral({"stability_limit": {"icl": limits}, "linear_order": {"icl": order}})
    )
    assert (finding.holds, bool(finding.qualification)) == (holds, limits[1] < limits[0])


@pytest.mark.parametrize("orders, holds", [([4.0, 3.0], True), ([4.0, 2.0], False)])
def test_third_order_with_damping(orders, holds):
    finding = later_schemes.third_order_with_damping(_spectral({"linear_order": {"wat2": orders}}))
    assert finding.holds == holds and finding.ours == f"{orders[0]:.1f} and {orders[1]:.1f}"


@pytest.mark.parametrize(
    "order, limit, radius, holds",
    [(4, np.inf, 0.8, True), (3, np.inf, 0.8, False), (4, 3.0, 0.8, False), (4, np.inf, 1.0, False)],
)
def test_order_stability_and_dissipation_at_once(order, limit, radius, holds):
    values = {
        "linear_order": (3, order),
        "stability_limit": (np.inf, limit),
        "infinite_frequency_radius": (0.8, radius),
    }
    spectral = _spectral({name: dict(zip(("esdirk3", "esdirk4"), both, strict=True)) for name, both in values.items()})
    assert later_schemes.order_stability_and_dissipation_at_once(spectral).holds == holds


@pytest.mark.parametrize("energy, motion, holds, qualified",
                         [(1e-11, 0.05, True, False), (1e-11, 0.9, True, True), (1e-3, 0.1, False, False)])  # fmt: skip
def test_energy_by_relaxation(energy, motion, holds, qualified):
    along = {"problem": ["hardening"], "steps_per_period": [15, 20], "variant": ["plain", "relaxed"]}
    data = filled(99.0, **along).to_dataset(name="max_energy_error").assign(return_error=filled(99.0, **along))
    data.max_energy_error.loc[{"variant": "relaxed"}] = energy
    data.return_error.loc[{"variant": "relaxed"}] = motion
    finding = later_schemes.energy_by_relaxation(data)
    assert (finding.holds, bool(finding.qualification)) == (holds, qualified)


@pytest.mark.parametrize("power, off, holds", [(0.0, 0.0, True), (1.0, 0.0, False), (0.0, 1e-3, False)])
def test_order_and_dissipation_of_mixed_pade(power, off, holds):
    terms, steps = xr.DataArray([1, 2, 3], dims="terms"), xr.DataArray([8, 16, 32], dims="long_steps")
    data = xr.Dataset(
        {"pade_error": (1.0 * steps) ** (power + 1 - 2 * terms).T, "pade_radius": 0.5 + off + 0.0 * terms},
        {"terms": terms, "long_steps": steps},
        {"rho_inf": 0.5},
    )
    assert later_schemes.order_and_dissipation_of_mixed_pade(data.transpose("terms", ...)).holds == holds
