"""Cost at an allowed error, and which scheme dominates which."""

import numpy as np
import xarray as xr

from paper.respects import costs, dominated_by, respects
from tests.paper.claims.made_up import filled

STEPS = [10, 20, 40]


def _runs(problem, name, errors, schemes=("one", "two")):
    """Runs with errors by scheme and step; the first scheme takes one force evaluation a step, the second two."""
    data = filled(0.0, problem=[problem], scheme=list(schemes), steps_per_period=STEPS).to_dataset(name=name)
    data[name][0] = errors
    data["force_evaluations_per_step"] = data[name] * 0 + [[1.0], [2.0]]
    titles = {"problem_title": ("problem", [problem]), "scheme_title": ("scheme", list(schemes))}
    return data.assign_coords(titles)


def test_the_cost_is_that_of_the_coarsest_step_from_which_all_finer_ones_keep_the_error():
    kinks = _runs("yielding", "error", [[0.001, 0.1, 0.005], [0.1, 0.009, 0.001]])
    structures = _runs("bar", "displacement_error", [[0.1, 0.1, 0.1], [0.001, 0.001, 0.001]])
    np.testing.assert_array_equal(costs(kinks, structures), [[40, 40], [np.nan, 20]])


def _spectral(radii, limits=(np.inf, np.inf)):
    along = {"scheme": ["one", "two"], "damping_ratio": [0.0]}
    names = [f"growth_{one}_from_{start}" for one in "uv" for start in "uv"]
    data = xr.Dataset({name: filled(0.0, **along) for name in names})
    data["infinite_frequency_radius"] = filled(1.0, **along) * [[radii[0]], [radii[1]]]
    data["stability_limit"] = filled(1.0, **along) * [[limits[0]], [limits[1]]]
    return data.assign(algorithmic_damping=filled(0.01, **along, dt_over_period=[0.05]))


def test_a_scheme_dominates_if_it_is_worse_in_nothing_and_better_in_something():
    forces = xr.DataArray([[10.0, 20.0], [5.0, 5.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated_by(respects(forces, _spectral([0.5, 0.5])), "two") == ["one"]
    assert dominated_by(respects(forces, _spectral([0.5, 0.5])), "one") == []
    # a scheme with the smaller spectral radius, or one that alone is unconditionally stable, is not dominated
    assert dominated_by(respects(forces, _spectral([0.5, 0.4])), "two") == []
    assert dominated_by(respects(forces, _spectral([0.5, 0.5], (2.0, np.inf))), "two") == []
    equal = xr.DataArray([[10.0, 10.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated_by(respects(equal, _spectral([0.5, 0.5])), "two") == []
    lost = xr.DataArray([[np.nan, 10.0]], {"scheme": ["one", "two"]}, ["problem", "scheme"])
    assert dominated_by(respects(lost, _spectral([0.5, 0.5])), "one") == ["two"]
