"""The samples beside the maps of stability."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import study
from reference.experiments.amplitudes import amplitudes
from study import io
from study.experiments.atlas import atlas

OPTIONS: dict[str, Any] = {
    "scheme": "rk4",
    "problems": ["double_well", "softening"],
    "dt_over_period": {"first": -2, "last": 0, "count": 9},
    "periods": 20,
    "portraits": {"points": 3, "samples": 12},
}


@pytest.fixture(scope="module")
def orbits(tmp_path_factory):
    """The exact orbits, and the folder where the maps look for them."""
    folder = tmp_path_factory.mktemp("exact")
    exact = amplitudes(OPTIONS["problems"], {"first": -0.5, "last": 0.5, "count": 5})
    exact.attrs = io.provenance("orbits", "a test")
    io.write(exact, folder / "results" / "reference" / "amplitudes.nc")
    return exact, folder


@pytest.fixture(scope="module")
def whole(orbits):
    """The maps and the samples, in one part."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(orbits[1])
        return atlas(**OPTIONS, tile=0, tiles=1)


def test_an_exact_orbit_is_closed_and_keeps_its_energy(orbits):
    exact, _ = orbits
    for name in OPTIONS["problems"]:
        problem, orbit = study.problems[name], exact.sel(problem=name).isel(amplitude=3)
        energy = [problem.energy(u, v) for u, v in zip(orbit.orbit_u.values, orbit.orbit_v.values, strict=True)]
        np.testing.assert_allclose(energy, problem.potential(orbit.u0.item()), rtol=1e-12)
        assert abs(orbit.orbit_u - orbit.u0).min() < 1e-12
        assert orbit.orbit_u[0] == orbit.orbit_u[-1] == orbit.orbit_u.max()


def test_samples_are_those_of_the_run(whole):
    maps, portraits = whole
    assert dict(portraits.sizes) == {"scheme": 1, "problem": 2, "amplitude": 3, "dt_over_period": 3, "sample": 13}
    assert set(portraits.amplitude.values) <= set(maps.amplitude.values)
    one = portraits.isel(scheme=0, amplitude=1, dt_over_period=1).sel(problem="double_well")
    every = one.every.item()
    dt = (one.dt_over_period * one.period).item()
    run = study.run("double_well", "rk4", dt=dt, steps=12 * every, u0=one.u0.item(), every=every)
    np.testing.assert_allclose(one.u, run.u, atol=1e-6)
    np.testing.assert_allclose(one.v, run.v, atol=1e-6)
    above_rest = run.v**2 / 2 + study.problems["double_well"].potential(run.u.values) + 1 / 8
    np.testing.assert_allclose(one.height, above_rest / above_rest[0], rtol=1e-5)
    # 12 of them go over most of the run
    assert 15 < 12 * every * one.dt_over_period < 20


def test_the_beginning_of_a_run_is_sampled_closely(whole):
    _, portraits = whole
    assert portraits.early_every.values.tolist() == [5, 1, 1]
    for place, every in enumerate([5, 1]):
        one = portraits.isel(scheme=0, amplitude=1, dt_over_period=place).sel(problem="softening")
        dt = (one.dt_over_period * one.period).item()
        run = study.run("softening", "rk4", dt=dt, steps=12 * every, u0=one.u0.item(), every=every)
        np.testing.assert_allclose(one.early_u, run.u, atol=1e-6)
        np.testing.assert_allclose(one.early_v, run.v, atol=1e-6)
    assert every * one.dt_over_period < 1 / 5


def test_tiles_make_up_the_whole(orbits, whole, monkeypatch):
    monkeypatch.chdir(orbits[1])
    parts = zip(*(atlas(**OPTIONS, tile=tile, tiles=2) for tile in (0, 1)), strict=True)
    for product, made in zip(whole, parts, strict=True):
        gathered = xr.concat(made, "amplitude", data_vars="minimal", coords="minimal", combine_attrs="override")
        xr.testing.assert_identical(gathered, product)
