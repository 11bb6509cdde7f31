"""Orders and errors of schemes on forces with kinks."""

import numpy as np
import xarray as xr

#: Problems whose force depends on the history of the motion.
REMEMBER = ["yielding", "hysteretic"]
#: Problems with a kink of the force, except contact.
KINKED = [*REMEMBER, "shaken"]
#: Observed order below which Runge-Kutta has lost its order. Ratio of the error of another scheme to the error of
#: Runge-Kutta above which Runge-Kutta is more accurate.
LOST, GAINED = 3.0, 1.5


def at_equal_forces(kinks: xr.Dataset) -> xr.DataArray:
    """Error of central difference over that of Runge-Kutta with as many forces, along the steps of Runge-Kutta.

    The error of central difference is interpolated between the steps tried, both as logarithms. The ratio is NaN where
    central difference would need more steps than were tried.
    """
    forces, error = (
        np.log(values) for values in (kinks.steps_per_period * kinks.force_evaluations_per_step, kinks.sampled_error)
    )

    def ratio(wanted: np.ndarray, wanted_errors: np.ndarray, forces: np.ndarray, errors: np.ndarray) -> np.ndarray:
        return np.exp(np.interp(wanted, forces, errors, right=np.nan) - wanted_errors)

    arguments = [values.sel(scheme=name) for name in ("rk4", "central_difference") for values in (forces, error)]
    along = [["steps_per_period"]]
    return xr.apply_ufunc(
        ratio, *arguments, input_core_dims=4 * along, output_core_dims=along, vectorize=True
    ).transpose("steps_per_period", ...)
