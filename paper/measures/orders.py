"""Observed orders of convergence, fitted where errors are neither dominated by round-off nor saturated."""

import numpy as np
import xarray as xr

from study.analysis.orders import observed_order

#: Measures of error whose order is fitted, with the number of periods of the run. Errors affect each other over time: a
#: loss of amplitude changes the period. The run is therefore as short as the measure permits. A mean over periods needs
#: three periods.
PERIODS = {
    "displacement_error": 1,
    "rms_displacement_error": 1,
    "phase_error": 1,
    "period_elongation": 3,
    "amplitude_decay": 3,
    "max_energy_error": 1,
    "energy_drift": 1,
}
#: Smallest relative error in a fit; smaller errors are near the round-off of the run.
FLOOR = 1e-10
#: Largest relative error in a fit, except for phase errors; larger errors are saturated.
SATURATED = 0.5
#: Number of step sizes in a fit, each twice the next finer one.
POINTS = 5
#: Decrease of an order above which it counts as lost.
LOST = 0.5
#: Largest difference between the slopes of neighbouring pairs of step sizes in a fit.
STEADY = 0.2


def order_at_finest(error: xr.DataArray) -> float:
    """Observed order of |error| at the finest ``POINTS`` consecutive step sizes with valid errors.

    Only step sizes that are the finest one times a power of two are used. An error is valid above ``FLOOR`` and, unless
    it is a phase error, below ``SATURATED``. The order is NaN if there are fewer such step sizes, or if the slope
    changes between them: two errors of different order are then of similar size or of opposite sign.
    """
    octaves = np.log2(error.steps_per_period.values[-1] / error.steps_per_period.values)
    error = error[octaves == np.round(octaves)]
    values = np.abs(error.values)
    ceiling = np.inf if error.name == "phase_error" else SATURATED
    valid = (values > FLOOR) & (values < ceiling)
    windows = [slice(end - POINTS, end) for end in range(len(valid), POINTS - 1, -1)]
    finest = next((window for window in windows if valid[window].all()), None)
    if finest is None:
        return np.nan
    steps, values = error.steps_per_period.values[finest], values[finest]
    slopes = np.diff(np.log(values)) / np.diff(np.log(steps))
    return observed_order(steps, values) if np.ptp(slopes) < STEADY else np.nan


def lost(orders: xr.Dataset) -> xr.DataArray:
    """Whether a quantity has lost order, or does not converge, over (scheme, circumstance, quantity)."""
    failed = orders.status == orders.status.flag_meanings.split().index("failed")
    return failed | (orders.order - orders.observed_order > LOST)
