"""Observed orders of convergence, fitted where neither round-off nor the size of the error spoils them."""

import numpy as np
import xarray as xr

#: The measures of error whose order is fitted, and how the tables call them.
MEASURES = {
    "max_trajectory_error": "Trajectory",
    "phase_error": "Phase",
    "amplitude_decay": "Amplitude",
    "max_energy_error": "Energy",
}
#: Relative errors below this are near the round-off of a hundred periods, which no order describes.
FLOOR = 1e-10
#: Above this an error other than a delay cannot grow much further, and says nothing of the step.
SATURATED = 0.5
#: Points of a fit, the finest ones above the floor.
POINTS = 5
#: How far a point may be off the fitted line in ln |error|.
STRAIGHT = 0.1


def observed_order(error: xr.DataArray) -> float:
    """Slope of log |error| over log Δt at the finest ``POINTS`` step sizes above the floor.

    NaN with fewer points, and where they lie on no line: two causes of error of different order are then of one size,
    or of opposite sign.

    The error in percent of the energy is taken as a fraction, so that one floor serves all measures.
    """
    values = np.abs(error.values) / (100 if error.attrs["units"] == "percent" else 1)
    ceiling = np.inf if error.name == "phase_error" else SATURATED
    valid = np.flatnonzero((values > FLOOR) & (values < ceiling))[-POINTS:]
    if len(valid) < POINTS:
        return np.nan
    x, y = np.log(error.steps_per_period.values[valid]), np.log(values[valid])
    fit = np.polyfit(x, y, 1)
    return -fit[0] if np.max(np.abs(np.polyval(fit, x) - y)) < STRAIGHT else np.nan
