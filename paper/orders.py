"""Observed orders of convergence, fitted where errors are neither dominated by round-off nor saturated."""

import numpy as np
import xarray as xr

#: Measures of error whose order is fitted, with the number of periods of the run. Errors affect each other over time: a
#: loss of amplitude changes the period. The run is therefore the shortest that has the measure, which is three periods
#: for means over periods.
PERIODS = {
    "max_trajectory_error": 1,
    "rms_trajectory_error": 1,
    "phase_error": 1,
    "period_elongation": 3,
    "amplitude_decay": 3,
    "max_energy_error": 1,
    "energy_drift": 1,
}
#: Smallest relative error in a fit; smaller errors are near the round-off of such a run.
FLOOR = 1e-10
#: Largest error in a fit, except for phase errors; larger errors are saturated.
SATURATED = 0.5
#: Number of neighbouring octaves of the step size in a fit; they are the finest above the floor.
POINTS = 5
#: Largest change of the slope from one step size to the next within a fit.
STEADY = 0.2


def observed_order(error: xr.DataArray) -> float:
    """Slope of log |error| over log Δt at the finest ``POINTS`` neighbouring octaves of the step size above the floor.

    Octaves are counted from the finest step size; steps between them are omitted. The order is NaN if there are fewer
    points, or if the slope changes within them: two errors of different order are then of similar size or of opposite
    sign.

    An error in percent is taken as a fraction, so that one floor serves all measures.
    """
    octaves = np.log2(error.steps_per_period.values[-1] / error.steps_per_period.values)
    error = error[octaves == np.round(octaves)]
    values = np.abs(error.values) / (100 if error.attrs["units"] == "percent" else 1)
    ceiling = np.inf if error.name == "phase_error" else SATURATED
    valid = (values > FLOOR) & (values < ceiling)
    windows = [slice(end - POINTS, end) for end in range(len(valid), POINTS - 1, -1)]
    finest = next((window for window in windows if valid[window].all()), None)
    if finest is None:
        return np.nan
    x, y = np.log(error.steps_per_period.values[finest]), np.log(values[finest])
    return -np.polyfit(x, y, 1)[0] if np.ptp(np.diff(y) / np.diff(x)) < STEADY else np.nan
