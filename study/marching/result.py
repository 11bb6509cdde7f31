"""What a march gives back: how each run ended and what was observed, and both as a labelled dataset."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from study.datasets import VERSION, flags
from study.marching.shapes import Counts, Flags, Numbers, Observed
from study.observer.base import Observer
from study.problem.definition import Problem
from study.scheme.base import Scheme

COMPLETED, NEWTON_FAILED, NOT_FINITE = 0, 1, 2

STATUS_ATTRIBUTES = flags("how the run ended", ("completed", "newton_not_converged", "not_finite"), np.int32)

FAILED_AT_STEP_ATTRIBUTES = {"long_name": "step at which the run failed, -1 where it did not", "units": "1"}


class Result(NamedTuple):
    """What a march gives back; with lanes, every array has an axis of lanes in front.

    Attributes
    ----------
    status
        ``COMPLETED``, ``NEWTON_FAILED`` or ``NOT_FINITE``.
    failed_at_step
        Step at which the run failed, −1 if it completed.
    values
        Variables of the reductions; meaningless if the run failed.
    samples
        Variables of the records, with the samples along the first axis; NaN from a failure on.
    """

    status: Flags
    failed_at_step: Flags
    values: dict[str, Observed]
    samples: dict[str, Observed]


def labelled(
    result: Result,
    problem: Problem,
    scheme: Scheme,
    observers: Sequence[Observer],
    dt: Numbers,
    steps: Counts,
    every: int,
    samples: int,
    ensemble: bool,
) -> xr.Dataset:
    """The result as the dataset that :func:`study.run` returns.

    Parameters
    ----------
    result
        Result of the march, with NumPy arrays.
    dt, steps
        Step size and number of steps: one number, or one per lane.
    every, samples
        Steps between two samples, and how many samples follow the first.
    ensemble
        Whether the arrays have an axis of lanes in front.
    """
    attributes = {name: a for observer in observers for name, a in observer.variables.items()}
    lane = ("lane",) if ensemble else ()
    component = ("component",) if np.ndim(problem.u0) else ()
    along = "sample" if dt.ndim else "t"
    within_run = np.arange(samples + 1) * every <= steps
    data = {
        "status": (lane, np.asarray(result.status, dtype=np.int32), STATUS_ATTRIBUTES),
        "failed_at_step": (lane, np.asarray(result.failed_at_step), FAILED_AT_STEP_ATTRIBUTES),
    }
    for name, value in result.values.items():
        dims = (*lane, *component[: np.ndim(value) - len(lane)])
        failed = np.reshape(result.status != COMPLETED, (-1,) * len(lane) + (1,) * (len(dims) - len(lane)))
        # NaN turns whole numbers into doubles, which hold all of them
        data[name] = (dims, np.where(failed, np.nan, value), attributes[name])
    for name, value in result.samples.items():
        extra = component[: np.ndim(value) - len(lane) - 1]
        if not within_run.all():
            # the march leaves its last state in the place of the next sample
            value = np.where(within_run.reshape((1,) * len(lane) + (-1,) + (1,) * len(extra)), value, np.nan)
        data[name] = ((*lane, along, *extra), np.asarray(value), attributes[name])
    coordinates = {}
    if samples:
        t = np.multiply.outer(dt, np.arange(samples + 1) * every)
        coordinates["t"] = ((*lane, "sample") if dt.ndim else "t", t, {"long_name": "elapsed time", "units": "s"})
    return xr.Dataset(
        data,
        coordinates,
        {
            "title": f"{scheme.title} on the {problem.title}",
            "problem": problem.title,
            "scheme": scheme.title,
            "version": VERSION,
        },
    )
