"""Claims of practice on forces that yield: each check can come out either way."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import materials

KINKED = ["yielding", "hysteretic", "shaken"]


def _kinks(gain=10.0, order=2.0, imbalance=1e-13, equal=1.0):
    error = np.full((3, 3, 2), 1e-2)
    error[:, 1] /= gain
    error[:, 2] *= equal
    return xr.Dataset(
        {
            "error": (("problem", "scheme", "steps_per_period"), error),
            "observed_order": (("problem", "scheme"), np.full((3, 3), order)),
            "max_energy_imbalance": (("problem", "scheme", "steps_per_period"), np.full((3, 3, 2), imbalance)),
        },
        {
            "problem": KINKED,
            "scheme": ["average_acceleration", "rk4", "central_difference"],
            "steps_per_period": [64, 256],
        },
    )


@pytest.mark.parametrize(
    "gain, order, equal, verdict",
    [
        (1.0, 2.0, 1.0, "reproduced"),
        (1.0, 4.0, 1.0, "not reproduced"),
        (10.0, 2.0, 0.1, "reproduced with a qualification"),  # a smaller error at equal steps, not at equal forces
        (10.0, 2.0, 1.0, "not reproduced"),
    ],
)
def test_the_order_does_not_matter_if_neither_order_nor_error_at_equal_forces_does(gain, order, equal, verdict):
    assert materials.order_does_not_matter({"kinks": _kinks(gain, order, equal=equal)}).verdict == verdict


@pytest.mark.parametrize(
    "imbalance, error, holds", [(9e-7, 1.1e-3, False), (1.1e-6, 1.1e-3, True), (9e-7, 0.9e-3, True)]
)
def test_a_balance_that_is_kept_by_a_wrong_motion_is_no_verdict(imbalance, error, holds):
    kinks = _kinks(imbalance=imbalance)
    kinks["error"][:] = error
    assert materials.balance_is_a_verdict({"kinks": kinks}).holds == holds


@pytest.mark.parametrize("step, holds", [(1 / 19, True), (1 / 21, False), (np.nan, False)])
def test_twenty_steps_are_enough_where_no_oscillator_needs_more(step, holds):
    needed = xr.DataArray(
        [[[0.1, step]]],
        dims=("scheme", "period", "reduction"),
        coords={"scheme": ["average_acceleration"], "period": [1.0], "reduction": [1.0, 4.0]},
    )
    assert materials.twenty_steps_for_the_peak({"spectrum": needed.to_dataset(name="step_needed")}).holds == holds


@pytest.mark.parametrize("damped, holds", [(1.4, False), (1.6, True)])
def test_the_order_of_the_alpha_method_is_that_with_damping(damped, holds):
    order = xr.DataArray(
        [[2.0, damped]],
        dims=("scheme", "damping_ratio"),
        coords={"scheme": ["hht_alpha"], "damping_ratio": [0.0, 0.1]},
    )
    assert materials.order_of_the_alpha_method({"spectral": order.to_dataset(name="linear_order")}).holds == holds
