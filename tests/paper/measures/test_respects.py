"""Cost at an allowed error, and which scheme dominates which."""

import numpy as np
import xarray as xr

from paper.measures.respects import costs, respects
from study.runs.needs import dominated, joined_needs, needs
from tests.paper.claims.made_up import filled
from tests.runs.made_up import runs


def test_the_cost_is_that_of_the_need_in_a_time_scale():
    fine = runs([[0.2, 0.05, 0.005, 0.0005], [0.2] * 4, [0.005] * 4])
    drift = runs([[0.0] * 4] * 3, problem="records").isel(quantity=[0]).assign_coords(quantity=["peak drift"])
    forces = costs(joined_needs([needs(fine, [0.01]), needs(drift, [0.01])]))
    # records have no displacement
    np.testing.assert_array_equal(forces, [[32, np.nan, 40]])


def _spectral(radii, limits=(np.inf, np.inf)):
    along = {"scheme": ["one", "two"], "damping_ratio": [0.0]}
    names = [f"growth_{variable}_from_{start}" for variable in "uv" for start in "uv"]
    data = xr.Dataset({name: filled(0.0, **along) for name in names})
    data["infinite_frequency_radius"] = filled(1.0, **along) * [[radii[0]], [radii[1]]]
    data["stability_limit"] = filled(1.0, **along) * [[limits[0]], [limits[1]]]
    return data.assign(algorithmic_damping=filled(0.01, **along, step_size_over_period=[0.05]))


def test_a_scheme_dominates_if_it_is_worse_in_nothing_and_better_in_something():
    forces = xr.DataArray([[10.0, 20.0], [5.0, 5.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated(respects(forces, _spectral([0.5, 0.5])), "two") == ["one"]
    assert dominated(respects(forces, _spectral([0.5, 0.5])), "one") == []
    # a scheme with the smaller spectral radius, or one that alone is unconditionally stable, is not dominated
    assert dominated(respects(forces, _spectral([0.5, 0.4])), "two") == []
    assert dominated(respects(forces, _spectral([0.5, 0.5], (2.0, np.inf))), "two") == []
    equal = xr.DataArray([[10.0, 10.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated(respects(equal, _spectral([0.5, 0.5])), "two") == []
    lost = xr.DataArray([[np.nan, 10.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated(respects(lost, _spectral([0.5, 0.5])), "one") == ["two"]
