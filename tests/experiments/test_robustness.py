"""Number of steps per period that keeps the energy."""

import xarray as xr

import study
from study.experiments.robustness import robustness


def test_the_steps_that_are_enough_are_enough(springs):
    ds = robustness(["hardening"], ["average_acceleration", "houbolt"], [8, 16, 32, 64, 128], [10, 50])
    needed = ds.fewest_steps_per_period.sel(problem="hardening", scheme="average_acceleration")
    assert (needed.sel(allowed_error=0.01) > needed.sel(allowed_error=0.1)).all() and needed.notnull().all()
    assert ds.fewest_steps_per_period.sel(scheme="houbolt", periods=50, allowed_error=0.01).isnull().all()
    one, enough = springs.sel(problem="hardening"), int(needed.sel(allowed_error=0.05, periods=50).item())
    for steps, kept in ((enough, True), (enough // 2, False)):
        runs = study.run(
            "hardening",
            "average_acceleration",
            dt=one.period.values / steps,
            u0=one.u0.values,
            steps=50 * steps,
            observe=["max_energy_error"],
        )
        assert bool((runs.max_energy_error <= 0.05).all()) == kept


def test_how_many_steps_are_enough_does_not_depend_on_longer_runs(springs):
    """The number of steps for short runs stays the same if longer runs are added, even if the longer runs fail."""
    short = robustness(["double_well"], ["average_acceleration"], [3, 4, 5, 20], [20])
    both = robustness(["double_well"], ["average_acceleration"], [3, 4, 5, 20], [20, 200])
    xr.testing.assert_equal(
        short.fewest_steps_per_period.isel(periods=0, drop=True),
        both.fewest_steps_per_period.isel(periods=0, drop=True),
    )
