"""Energy and phase errors of very long runs, and the growth of their round-off, as means over the runs."""

import numpy as np
import xarray as xr

from study import io
from study.declaration.experiment import experiment
from study.marching.result import FAILED_AT_STEP_ATTRIBUTES, STATUS_ATTRIBUTES

#: Arithmetic of the runs from which the round-off of all other runs is measured.
_LEAST_ROUND_OFF = "float64_compensated"


def growth(periods: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exponent k of the law rms(values) ~ periods^k over the last two decades of lengths, and its standard error.

    k is the least squares slope of log rms against log periods. Its error is the jackknife estimate over runs, because
    the values of one run at several lengths share their round-off. Both are NaN if there are fewer than three lengths
    in the last two decades, or fewer than two runs. They are also NaN if all values of a length, or all except one, are
    zero, or if a value is not finite.

    Parameters
    ----------
    periods, values
        Lengths in ascending order (periods,), and the values of the runs (..., periods, run).

    Returns
    -------
    exponent, error : numpy.ndarray
        Each of shape (...).
    """
    late = periods >= periods[-1] / 100
    runs = values.shape[-1]
    if late.sum() < 3 or runs < 2:
        nothing = np.full(values.shape[:-2], np.nan)
        return nothing, nothing
    x = np.log(periods[late]) - np.log(periods[late]).mean()
    squares = values[..., late, :] ** 2
    total = squares.sum(axis=-1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        # the slope is linear in the logarithms; it is computed with all runs, and with each run left out in turn
        whole, without = (x @ np.log(s) / (2 * x @ x) for s in (total, total - squares))
    error = np.sqrt((runs - 1) * without.var(axis=-1))
    known = np.isfinite(whole[..., 0] + error)
    return np.where(known, whole[..., 0], np.nan), np.where(known, error, np.nan)


def _described(values: xr.DataArray, long_name: str, units: str) -> xr.DataArray:
    return values.assign_attrs(long_name=long_name, units=units)


def summary(runs: xr.Dataset) -> xr.Dataset:
    """Means, root mean squares and laws of growth of the errors over runs.

    Parameters
    ----------
    runs
        Errors, status and failing step of every run, each (scheme, arithmetic, step, periods, run).

    Returns
    -------
    xarray.Dataset
        Errors have the shape (scheme, arithmetic, step, periods), exponents and their standard errors
        (quantity, scheme, arithmetic, step). An error is NaN if one of its runs failed, and an
        exponent if one of its runs in the last two decades of lengths failed.
    """
    rounded = runs.arithmetic != _LEAST_ROUND_OFF
    less = runs - runs.sel(arithmetic=_LEAST_ROUND_OFF)
    errors = {
        "energy_error": runs.energy_error,
        "mean_energy_error": runs.mean_energy_error,
        "phase_error": runs.phase_error,
        "energy_round_off": less.mean_energy_error.where(rounded),
        "phase_round_off": less.phase_error.where(rounded),
    }
    mean = {name: values.mean("run", skipna=False) for name, values in errors.items()}
    rms = {name: np.sqrt((values**2).mean("run", skipna=False)) for name, values in errors.items()}
    growing = [name for name in errors if name != "energy_error"]
    exponent, exponent_error = growth(runs.periods.values, np.stack([errors[name] for name in growing]))
    first_to_fail = runs.isel(run=runs.failed_at_step.where(runs.failed_at_step >= 0, np.inf).argmin("run"))
    than_exact, slope = "less the value in compensated double precision", "slope of log rms quantity over log periods"
    along = ("quantity", "scheme", "arithmetic", "step")
    return xr.Dataset(
        {
            "energy_error": _described(mean["energy_error"], "signed energy error at the end, mean of runs", "1"),
            "max_energy_error": _described(
                runs.max_energy_error.max("run", skipna=False),
                "largest energy error, eq. (17) of Xie (1996)",
                "1",
            ),
            "mean_energy_error": _described(
                mean["mean_energy_error"], "signed energy error, mean over the run and of runs", "1"
            ),
            "phase_error": _described(mean["phase_error"], "delay at the end in periods, mean of runs", "1"),
            "energy_round_off": _described(
                rms["energy_round_off"], f"mean energy error {than_exact}, rms of runs", "1"
            ),
            "energy_bias": _described(mean["energy_round_off"], f"mean energy error {than_exact}, mean of runs", "1"),
            "phase_round_off": _described(rms["phase_round_off"], f"delay in periods {than_exact}, rms of runs", "1"),
            "phase_bias": _described(mean["phase_round_off"], f"delay in periods {than_exact}, mean of runs", "1"),
            "exponent": (
                along,
                exponent,
                {"long_name": f"{slope}, least squares over the last two decades", "units": "1"},
            ),
            "exponent_error": (
                along,
                exponent_error,
                {"long_name": "standard error of the exponent, by the jackknife over runs", "units": "1"},
            ),
            "status": first_to_fail.status.assign_attrs(STATUS_ATTRIBUTES, long_name="how the first run to fail ended"),
            "failed_at_step": first_to_fail.failed_at_step.assign_attrs(FAILED_AT_STEP_ATTRIBUTES),
            "runs": ((), runs.sizes["run"], {"long_name": "runs with each kind of step size", "units": "1"}),
            "spread_of_steps": (
                (),
                (runs.step_size.max() - runs.step_size.min()).item() / runs.step_size.mean().item(),
                {"long_name": "spread of the step sizes", "units": "1"},
            ),
        },
        coords={"quantity": ("quantity", growing, {"long_name": "growing quantity"})},
    ).set_coords(["runs", "spread_of_steps"])


@experiment("long_times", options=lambda configuration: {}, reads=lambda options: ["long_runs"])
def long_times() -> xr.Dataset:
    """Find the mean errors of very long runs, their round-off, and the laws of growth of both.

    The round-off of a run is its difference from the run with the same step size in compensated double precision.

    Returns
    -------
    xarray.Dataset
        The result of :func:`summary`.

    Raises
    ------
    FileNotFoundError
        If ``results/long_runs.nc`` has not been made.
    """
    runs = io.open_dataset("long_runs")
    return summary(runs).assign_attrs(title=runs.title.removesuffix(", one by one"))
