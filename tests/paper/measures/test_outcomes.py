"""Steps that keep the energy at all amplitudes, from a made-up map."""

import numpy as np
import xarray as xr

from paper.measures.outcomes import fewest_steps, most_steps


def test_the_fewest_steps_are_those_of_the_largest_step_below_which_all_steps_keep_the_energy():
    # over amplitude and Δt/T; the second scheme fails at the finest step at one amplitude
    errors = [[[0.01, 0.02, 0.3, 0.05], [0.01, 0.04, 0.04, 0.05]], [[np.nan, 0.1, 0.1, 0.1], [0.0, 0.1, 0.1, 0.1]]]
    maps = xr.Dataset(
        {"max_energy_error": (("scheme", "amplitude", "step_size_over_period"), errors)},
        {"scheme": ["one", "two"], "step_size_over_period": [0.01, 0.03, 0.1, 0.2]},
    )
    assert fewest_steps(maps, 0.05).sel(scheme="one").item() == 34  # 1/34 < 0.03 < 1/33
    assert fewest_steps(maps, 0.3).sel(scheme="one").item() == 5
    assert np.isnan(fewest_steps(maps, 0.5).sel(scheme="two").item())
    assert most_steps(maps) == "more than 100"
