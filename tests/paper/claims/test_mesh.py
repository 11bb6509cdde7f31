"""Claims on the frequencies of mesh and motion: the check is tested where it holds and where it fails."""

import numpy as np
import pytest
import xarray as xr

from paper.claims import mesh as claims


def _mesh(seconds, ratios=(20.0, 200.0, 2000.0)):
    """A dataset like mesh.nc of one panel: explicit times grow with the ratio of frequencies, implicit ones do not."""
    ratios = np.array(ratios)
    times = np.stack([ratios, np.broadcast_to(seconds, ratios.shape)], axis=1)
    data = xr.Dataset(
        {"seconds_per_step": (("case", "scheme"), times), "crossover": ("case", ratios * times[:, 1] / times[:, 0])},
        {"scheme": ["central_difference", "average_acceleration"], "mesh_ratio": ("case", ratios)},
    )
    return data.assign_coords(rows=("case", [4] * len(ratios)), columns=("case", [4] * len(ratios)))


@pytest.mark.parametrize("crossover, holds", [(100, True), (10, False), (1000, False)])
def test_the_mesh_a_hundred_times_the_motion_or_not(crossover, holds):
    finding = claims.hundred_times_the_motion(_mesh(crossover))
    assert finding.holds == holds and finding.ours == f"meshes: {crossover:,}"
    assert bool(finding.qualification) != holds


def test_crossovers_are_those_of_all_cases_that_have_one():
    assert claims.crossovers(_mesh(np.array([200.0, np.nan, 504.0]))).values.tolist() == [200.0, 500.0]
    nothing = claims.hundred_times_the_motion(_mesh(np.nan))
    assert not nothing.holds and nothing.ours == "none"
