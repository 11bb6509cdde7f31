"""Maps of outcomes over amplitude and step size."""

import subprocess
import sys

import pytest
import xarray as xr

import study
from reference.amplitudes import amplitudes
from study.analysis.outcomes import OUTCOMES
from study.experiments.atlas import atlas

#: More amplitudes than a tile of an ensemble has lanes.
MANY = {"first": -1.0, "last": 1.0, "count": 150}


EXPONENTS = {"first": -1.0, "last": 1.0, "count": 6}


GRID = {"first": -1.5, "last": 0.0, "count": 7}


@pytest.fixture
def springs(tmp_path, monkeypatch):
    """A folder with the exact periods over two decades of amplitude."""
    monkeypatch.chdir(tmp_path)
    dataset = amplitudes(["hardening", "softening", "double_well"], EXPONENTS)
    study.datasets.write(dataset.assign_attrs(source=study.datasets.SOURCE), "results/reference/amplitudes.nc")
    return dataset


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "gauss4", "rk4"])
def test_a_map_does_not_depend_on_its_tiles_nor_on_the_cores(springs, monkeypatch, scheme):
    many = amplitudes(["softening", "double_well"], MANY)
    study.datasets.write(many.assign_attrs(source=study.datasets.SOURCE), "results/reference/amplitudes.nc")
    portraits = {"points": 3, "samples": 5}
    arguments = {
        "problems": ["softening", "double_well"],
        "dt_over_period": GRID,
        "periods": 20,
        "portraits": portraits,
    }
    whole, _ = atlas(scheme, **arguments, tile=0, tiles=1)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    tiles = [atlas(scheme, **arguments, tile=tile, tiles=3) for tile in range(3)]
    for tile, (part, _) in enumerate(tiles):
        study.datasets.write(part.assign_attrs(source=study.datasets.SOURCE), f"{tile}.nc")
    gather = [
        sys.executable,
        "-m",
        "study.pipeline.gather",
        "gathered.nc",
        "scheme,amplitude",
        *(f"{k}.nc" for k in range(3)),
    ]
    subprocess.run(gather, check=True)
    xr.testing.assert_identical(xr.load_dataset("gathered.nc").drop_attrs(), whole.drop_attrs())


def test_a_tile_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="there is no tile -1 among 3"):
        atlas("rk4", ["hardening"], GRID, 20, {"points": 3, "samples": 5}, tile=-1, tiles=3)


def test_the_samples_of_an_orbit_that_closes_do_not_fall_into_one_place(springs):
    _, samples = atlas("rk4", ["hardening"], GRID, 100, {"points": 7, "samples": 20}, tile=0, tiles=1)
    for every in samples.every.values.tolist():
        assert every >= 2 and all(every % n for n in range(2, every))


def test_a_map_shows_the_linear_limit_at_small_amplitude(springs):
    fine = {"first": -0.7, "last": -0.3, "count": 41}
    one, _ = atlas("central_difference", ["hardening"], fine, 300, {"points": 2, "samples": 2}, tile=0, tiles=6)
    one = one.squeeze()
    lost = one.outcome.values >= OUTCOMES.index("growing")
    first = one.dt_over_period.values[lost.argmax()]
    limit = 2 / (one.highest_frequency * one.period).item()
    # the tangent is as stiff as that at one end of the swing only
    assert limit * 0.9 < first < 1.15 * limit
