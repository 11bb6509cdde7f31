"""Errors and costs of controlled steps, compared with equal steps."""

import xarray as xr

from study.sizes import fewest

#: Problem and scheme that the figure and the text show.
PROBLEM, SCHEME = "hardening", "average_acceleration"
#: Bounds on the largest energy error of the last period divided by the largest of the first period. Above ``DRIFTS``
#: the energy drifts. Below ``KEPT`` it does not.
DRIFTS, KEPT = 3.0, 1.1
#: Number of steps per period in the cells of Tables 1 and 2 that the text compares.
CELL = 50
#: Relative error of the displacement at which numbers of force evaluations are compared. Ratio of two such numbers
#: above which they differ clearly.
ALLOWED, CLEARLY = 0.01, 1.25
#: Ratio of estimate to true error above which an estimator is misled.
FOOLED = 2.0
#: Linear structure with a stiff mode that does not matter for the accuracy, and oscillator under a load with a kink.
STIFF, PULSE = ["stiff_soft"], "pulse"


def growth(step_control: xr.Dataset) -> xr.DataArray:
    """Largest energy error in the last period divided by the largest in the first, (problem, with_equal)."""
    history = step_control.max_energy_error_of_period
    return history.isel(period_number=-1) / history.isel(period_number=0)


def with_control(control_cost: xr.Dataset, allowed: float) -> tuple[xr.DataArray, xr.DataArray]:
    """Fewest force evaluations for an error with controlled and with equal steps, each of shape (problem, scheme)."""
    controlled = fewest(control_cost.sampled_error, control_cost.force_evaluations, allowed, "tolerance")
    return controlled, fewest(
        control_cost.equal_sampled_error, control_cost.equal_force_evaluations, allowed, "steps_per_sample"
    )


def ratio_of_forces(control_cost: xr.Dataset, allowed: float) -> xr.DataArray:
    """Fewest force evaluations for an error with controlled steps over those with equal steps, (problem, scheme)."""
    controlled, equal = with_control(control_cost, allowed)
    return controlled / equal


def ratio_at_equal_steps(controlled_1996: xr.Dataset, energy_error: xr.Dataset) -> xr.DataArray:
    """Energy error with controlled steps over that with as many equal steps, for the cells that both datasets have."""
    equal = energy_error.max_energy_error.sel(period_used="exact")
    return controlled_1996.max_energy_error.isel(controller=0) / equal
