"""The form of the runs of a problem, ``runs/PROBLEM``: coordinates, properties of the problem, and attributes.

Errors and costs are over (scheme, size, quantity, periods) or some of these dimensions.
"""

from typing import Any

import numpy as np
import xarray as xr
from jaxtyping import Float, Int

from study.experiments import coordinates
from study.io import flags
from study.marching.result import STATUSES_OR_NOT_RUN
from study.runs.needs import ATTRIBUTES

#: Attributes of the variables that needs and decisions lack, or that have another meaning there.
_OF_RUNS = {
    "largest_error": {"long_name": "largest error from all starts", "units": "1"},
    "step_size": {"long_name": "step size", "units": "s"},
    "status": flags("how the run ended", STATUSES_OR_NOT_RUN, np.int8),
    "proposed": {"long_name": "1 if the step may be an answer, 0 if it only confirms coarser ones", "units": "1"},
    "tried": {"long_name": "1 if the scheme was run with this step size", "units": "1"},
    "uncertainty": {"long_name": "difference of the two solvers of the reference, relative", "units": "1"},
    "periods": {"long_name": "duration of the run in time scales", "units": "1"},
}


Sizes = Float[np.ndarray, " sizes"]
Flags = Int[np.ndarray, " sizes"]


def divides(step_sizes: Sizes, spacing: float) -> Flags:
    """1 for step sizes that are an integer fraction or multiple of ``spacing``, or if it is NaN; 0 for others."""
    ratio = np.maximum(spacing / step_sizes, step_sizes / spacing)
    return (np.isnan(ratio) | np.isclose(ratio, np.round(ratio))).astype(np.int8)


def described(ds: xr.Dataset, error: str, **properties: Any) -> xr.Dataset:
    """The runs with all coordinates and attributes.

    Parameters
    ----------
    ds
        The runs with the coordinates ``step_size`` in s and ``steps_per_period`` along ``size``.
    error
        Description of the errors.
    properties
        Properties of the problem, coordinates without a dimension. They include ``time_scale``, ``highest_frequency``
        and ``spacing``, the time between the samples of a record, NaN if there is none.
    """
    ds = ds.assign_coords(
        **coordinates.scheme_coordinates(ds.scheme.values.tolist()),
        omega_step=("size", properties["highest_frequency"] * ds.step_size.values),
        divides=("size", divides(ds.step_size.values, properties["spacing"])),
        duration=("periods", ds.periods.values * properties["time_scale"]),
        **properties,
    )
    for name, attributes in (ATTRIBUTES | _OF_RUNS | {"error": {"long_name": error, "units": "1"}}).items():
        if name in ds.variables and not ds[name].attrs:
            ds[name].attrs = attributes
    return ds.assign_attrs(title=f"Errors and costs of the schemes: {properties['problem_title']}")
