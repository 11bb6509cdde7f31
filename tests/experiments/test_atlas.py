"""Maps of outcomes over amplitude and step size."""

import pytest
import xarray as xr

import study
from pipeline import gather
from reference.experiments.amplitudes import amplitudes
from study.analysis.outcomes import Outcome
from study.experiments.atlas import atlas

GRID = {"first": -1.5, "last": 0.0, "count": 7}


@pytest.fixture(scope="module")
def many():
    """Exact periods of a spring at 150 amplitudes, more than two tiles of lanes."""
    dataset = amplitudes(["softening"], {"first": -1.0, "last": 1.0, "count": 150})
    return dataset.assign_attrs(source=study.io.SOURCE)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["average_acceleration", "rk4"])
def test_a_map_does_not_depend_on_its_tiles_nor_on_the_cores(many, tmp_path, monkeypatch, scheme):
    """It alone compares a map of several tiles, gathered from files, with a whole one to the bit."""
    monkeypatch.chdir(tmp_path)
    study.io.write(many, "results/reference/amplitudes.nc")
    arguments = {"problems": ["softening"], "step_size_over_period": GRID, "periods": 20}
    whole = atlas(scheme, **arguments, tile=0, tiles=1)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    tiles = [atlas(scheme, **arguments, tile=tile, tiles=3) for tile in range(3)]
    for tile, part in enumerate(tiles):
        study.io.write(part.assign_attrs(source=study.io.SOURCE), f"{tile}.nc")
    gather.main("gathered.nc", "scheme,amplitude", [f"{tile}.nc" for tile in range(3)])
    xr.testing.assert_identical(xr.load_dataset("gathered.nc").drop_attrs(), whole.drop_attrs())


def test_an_unknown_tile_is_refused():
    with pytest.raises(ValueError, match="there is no tile -1 among 3"):
        atlas("rk4", ["hardening"], GRID, 20, tile=-1, tiles=3)


@pytest.mark.slow
def test_a_map_shows_the_linear_limit_at_small_amplitude(springs):
    fine = {"first": -0.7, "last": -0.3, "count": 41}
    tile = atlas("central_difference", ["hardening"], fine, 300, tile=0, tiles=6).squeeze()
    lost = tile.outcome.values >= Outcome.GROWING
    first = tile.step_size_over_period.values[lost.argmax()]
    limit = 2 / (tile.highest_frequency * tile.period).item()
    # the tangent has its highest frequency only at the turning points, so steps slightly above the limit may be stable
    assert limit * 0.9 < first < 1.15 * limit
