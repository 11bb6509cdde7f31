"""Small datasets of the study, made by hand, for tests that open them by name."""

from pathlib import Path

import numpy as np
import xarray as xr

from study import io


def accuracy() -> xr.Dataset:
    """Two schemes of second order on the softening spring."""
    steps, lengths, schemes = [16, 64, 256, 1024], [10, 100], ["average_acceleration", "central_difference"]
    along = ("problem", "scheme", "steps_per_period", "periods")
    error = np.multiply.outer([4.0, 2.0], np.multiply.outer(1.0 / np.square(steps), lengths))[None]
    return xr.Dataset(
        {
            "max_trajectory_error": (along, error, {"units": "1"}),
            "flagged": (("measure", *along), np.zeros((1, *error.shape), int)),
            "uncertainty": (("measure", "problem", "periods"), np.zeros((1, 1, 2))),
            "newton_iterations": (along, np.zeros(error.shape), {"units": "1"}),
        },
        {
            "problem": ["softening"],
            "scheme": schemes,
            "steps_per_period": steps,
            "periods": lengths,
            "measure": ["max_trajectory_error"],
        },
    )


def work_precision() -> xr.Dataset:
    """Times of the steps of these schemes; central difference is ten times cheaper a step."""
    errors = accuracy()
    along = ("problem", "scheme", "steps_per_period")
    per_step = np.broadcast_to(np.array([50.0, 5.0])[None, :, None], (1, 2, errors.sizes["steps_per_period"]))
    return errors.assign(
        median_time_per_step=(along, per_step, {"units": "ns"}),
        spread_of_time_per_step=(along, per_step / 10, {"units": "ns"}),
    ).assign_coords(forces_per_step=("scheme", [1, 1]), forces_per_iteration=("scheme", [0, 0]))


def neighbours() -> xr.Dataset:
    """The same errors from starts beside."""
    return accuracy().expand_dims(start=["below", "above"])


def energy_error() -> xr.Dataset:
    """Energy errors of Houbolt's method on the hardening spring that halve with the step size."""
    error = np.array([[[[80.0], [40.0]]]])
    return xr.Dataset(
        {"max_energy_error": (("period_used", "problem", "steps_per_period", "scheme"), error, {"units": "percent"})},
        {"period_used": ["printed"], "problem": ["hardening"], "steps_per_period": [100, 200], "scheme": ["houbolt"]},
    )


def write_to(results: Path) -> Path:
    """Write the datasets to a folder of results, and return the folder."""
    for make in (accuracy, neighbours, work_precision, energy_error):
        io.write(make().assign_attrs(source=io.SOURCE), results / f"{make.__name__}.nc")
    return results
