"""The cheapest scheme by target error and length of the run, from the work-precision dataset."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from study import datasets
from study.command import main
from study.experiments import labels
from study.recommendation import candidates


def recommendation(
    problems: Sequence[str], measures: Sequence[str], errors: Sequence[float], periods: Sequence[int]
) -> xr.Dataset:
    """Cheapest scheme, its steps per period and its time; empty and NaN where no scheme keeps the error."""
    data = datasets.open("work_precision")
    dims = ("problem", "measure", "error", "periods")
    shape = tuple(map(len, (problems, measures, errors, periods)))
    cheapest = np.full(shape, "", dtype=object)
    steps, seconds = np.full(shape, np.nan), np.full(shape, np.nan)
    for at in np.ndindex(shape):
        problem, measure, error, length = (
            values[i] for values, i in zip((problems, measures, errors, periods), at, strict=True)
        )
        for best in candidates(data, problem, error, measure, length).head(1).itertuples():
            cheapest[at], steps[at], seconds[at] = best.Index, best.steps_per_period, best.time
    return xr.Dataset(
        {
            "cheapest_scheme": (dims, cheapest.astype(str), {"long_name": "cheapest scheme, empty where none"}),
            "steps_per_period": (dims, steps, {"long_name": "steps per period that it needs", "units": "1"}),
            "time": (dims, seconds, {"long_name": "time of the run", "units": "s"}),
        },
        coords={
            **labels.problem_coordinates(problems),
            "measure": ("measure", list(measures), {"long_name": "measure of error"}),
            "error": ("error", list(errors), {"long_name": "largest error that may be made, a fraction", "units": "1"}),
            "periods": ("periods", list(periods), {"long_name": "length of the run in exact periods", "units": "1"}),
        },
        attrs={"title": "The cheapest scheme for an error that may be made"},
    )


if __name__ == "__main__":
    main(recommendation)
