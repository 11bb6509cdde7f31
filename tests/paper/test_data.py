"""Errors without meaning are left out, and schemes stand in the order in which they were chosen."""

import numpy as np
import xarray as xr

from paper.data import loss_of_amplitude, with_schemes


def test_a_ripple_of_the_amplitude_is_no_loss():
    """A true loss per period does not depend on the length of runs; a ripple divided by this length does."""
    steps = np.array([8, 16, 32, 64, 128, 256, 512])
    loss = 1.0 / steps**3
    ripple = np.array([3.0, -2.0, 1.0, -1.0, 0.5, 0.3, 0.2])
    late = np.where(steps < 30, 0.1, 1.0) * loss  # saturated at large steps
    per_period = np.stack([np.outer(loss, [1, 1]), np.outer(ripple, [1 / 3, 1 / 100]), np.stack([loss, late], 1)])
    errors = xr.Dataset(
        {"amplitude_decay": (("scheme", "steps_per_period", "periods"), per_period)},
        {"steps_per_period": steps, "periods": [3, 100]},
    )
    losses = loss_of_amplitude(errors, 3, 100).values
    np.testing.assert_allclose(losses[0], loss)
    assert np.isnan(losses[1]).all()
    np.testing.assert_array_equal(np.isnan(losses[2]), steps < 30)


def test_chosen_schemes_come_in_the_order_of_the_choice_or_the_first_ones_stand_in():
    dataset = xr.Dataset(coords={"scheme": ["a", "b", "c"]})
    assert with_schemes(dataset, ["c", "x", "a"]).scheme.values.tolist() == ["c", "a"]
    assert with_schemes(dataset, ["x", "y"]).scheme.values.tolist() == ["a", "b"]
