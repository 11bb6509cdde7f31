"""Orders and errors of schemes on forces with kinks."""

import xarray as xr

#: Problems whose force depends on the history of the motion.
REMEMBER = ["yielding", "hysteretic"]
#: Problems with a kink of the force, except contact.
KINKED = [*REMEMBER, "shaken"]
#: Observed order below which Runge-Kutta has lost its order. Ratio of the error of another scheme to the error of
#: Runge-Kutta above which Runge-Kutta is more accurate.
LOST, GAINED = 3.0, 1.5


def at_equal_forces(kinks: xr.Dataset) -> xr.DataArray:
    """Error of central difference with 4N steps per period divided by the error of Runge-Kutta with N, along N."""
    four_times = 4 * kinks.steps_per_period
    steps = kinks.steps_per_period[four_times.isin(kinks.steps_per_period)]
    central = kinks.error.sel(scheme="central_difference", steps_per_period=(4 * steps).values)
    return central.assign_coords(steps_per_period=steps.values) / kinks.error.sel(scheme="rk4", steps_per_period=steps)
