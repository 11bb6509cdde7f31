"""The runs of oscillators under records in the form of other runs."""

import numpy as np
import xarray as xr

from study.runs.decisions import of_records
from study.runs.needs import needs


def test_records_take_the_place_of_starts():
    """Two schemes, three step sizes and two records of 20 s; the second scheme refuses the oscillators."""
    error = np.full((2, 3, 2, 2, 1), np.nan)
    error[0] = np.array([0.5, 0.02, 0.001])[:, None, None, None]
    error[0, 1, 1, 0, 0] = 0.05  # the largest over records and periods decides
    error[0, 0, 0, 0, 0] = np.nan  # a run that failed
    along = ("scheme", "step_size", "record", "period", "reduction")
    spectrum = xr.Dataset(
        {
            "error": (along, error),
            "force_evaluations_per_step": (along, np.where(np.isnan(error), np.nan, 2.0)),
            "tangent_evaluations_per_step": (along, 0 * error),
            "factorisations_per_step": (along, 0 * error),
        },
        {
            "scheme": ["runs", "refuses"],
            "step_size": [0.1, 0.03, 0.02],
            "commensurate": ("step_size", [0, 0, 1]),
            "period": [0.2, 1.0],
            "duration": 20.0,
        },
    )
    runs = of_records(spectrum)
    assert runs.tried.transpose("scheme", "size").values.tolist() == [[1, 1, 1], [0, 0, 0]]
    assert (runs.starts, runs.decided, runs.time_scale) == (4, 100, 0.2)
    needed = needs(runs, [0.1, 0.01]).sel(quantity="peak drift", scheme="runs").isel(periods=0)
    free, practice = (needed.sel(condition=name) for name in ("any_step", "practice"))
    assert free.step_size.values.tolist() == [0.03, 0.02] and practice.step_size.values.tolist() == [0.02, 0.02]
    assert free.error[0] == 0.05 and free.force_evaluations[0] == 2 / 0.03
