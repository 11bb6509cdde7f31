"""The result of a march: how each run ended and the observed values, and both as a labelled dataset."""

from collections.abc import Sequence
from dataclasses import fields
from typing import NamedTuple

import numpy as np
import xarray as xr

from study.io import __version__, flags
from study.marching.shapes import CountPerRun, Displacements, Flags, Observed, PerRun
from study.mechanics.definition import Problem
from study.mechanics.loads import record_of
from study.observer.base import Observer
from study.observer.diagnostics import Restarts
from study.scheme.base import Scheme

COMPLETED, NO_SOLUTION, NOT_FINITE, UNBOUNDED = range(4)

STATUSES = "completed", "no_solution_found", "not_finite", "unbounded"
#: Statuses in experiments, where a scheme that refuses a problem has no run.
STATUSES_OR_NOT_RUN = (*STATUSES, "not_run")

STATUS_ATTRIBUTES = flags("how the run ended", STATUSES, np.int32)

FAILED_AT_STEP_ATTRIBUTES = {"long_name": "step at which the run failed, -1 where it did not", "units": "1"}


#: Attributes of the coordinates of an ensemble.
LANE_ATTRIBUTES = {
    "dt": {"long_name": "step size", "units": "s"},
    "steps": {"long_name": "number of steps", "units": "1"},
    "u0": {"long_name": "initial displacement", "units": "1"},
    "v0": {"long_name": "initial velocity", "units": "s-1"},
}

#: Largest number of values of an initial condition that an attribute may hold.
MOST_IN_ATTRIBUTE = 1000


class Result(NamedTuple):
    """The result of a march; with lanes, every array has an axis of lanes in front.

    Attributes
    ----------
    status
        ``COMPLETED``, ``NO_SOLUTION``, ``NOT_FINITE`` or ``UNBOUNDED``.
    failed_at_step
        Step at which the run failed, −1 if it completed.
    restarts
        Number of Newton iterations that failed and were started again with a safeguard.
    values
        Variables of the reductions; meaningless if the run failed.
    samples
        Variables of the records, with the samples along the first axis; meaningless from a failure on, or after the
        end of the run.
    """

    status: Flags
    failed_at_step: Flags
    restarts: Flags
    values: dict[str, Observed]
    samples: dict[str, Observed]


def _without_meaning(result: Result, steps: CountPerRun, every: int, samples: int) -> Flags:
    """Whether each sample is at or after the step that failed, or after the end; of shape (..., samples + 1)."""
    step = np.arange(samples + 1) * every
    failed_at = np.where(result.status == COMPLETED, steps + 1, result.failed_at_step)
    return step >= failed_at[..., None]


def nan_where(failed: Flags, value: np.ndarray) -> np.ndarray:
    """The values of a variable, NaN where the run failed."""
    # integers become doubles, which have NaN and represent all integers that occur here exactly
    return np.where(failed.reshape(failed.shape + (1,) * (value.ndim - failed.ndim)), np.nan, value)


def _parameters(scheme: Scheme) -> str:
    """Class and parameters of a scheme, as a string."""
    shown = {
        f.name: getattr(scheme, f.name) for f in fields(scheme) if not f.metadata.get("static")
    }  # labels are static
    values = (f"{name}={_parameters(x) if isinstance(x, Scheme) else repr(x)}" for name, x in shown.items())
    return f"{type(scheme).__name__}({', '.join(values)})"


class Labels:
    """Labels that turn results of one scheme on one problem into datasets."""

    def __init__(self, problem: Problem, scheme: Scheme, observers: Sequence[Observer]):
        self.attributes = {
            "status": STATUS_ATTRIBUTES,
            "failed_at_step": FAILED_AT_STEP_ATTRIBUTES,
            **Restarts.variables,
        }
        self.attributes |= {name: a for observer in observers for name, a in observer.variables.items()}
        self.dataset_attributes = {
            "title": f"{scheme.title} on the {problem.title}",
            "problem": problem.title,
            "scheme": scheme.title,
            "scheme_parameters": _parameters(scheme),
            "version": __version__,
            **record_of(problem.load),
        }
        self._component = ("component",) if np.ndim(problem.u0) else ()
        self._unknowns = np.size(problem.u0)

    def variable(self, name: str, value: np.ndarray, dims: tuple[str, ...]) -> tuple:
        """Dimensions, values and attributes of a variable; an axis of components in ``value`` is added to ``dims``."""
        if value.ndim > len(dims):
            is_of_unknowns = self._component and value.shape[-1] == self._unknowns
            dims = (*dims, "component" if is_of_unknowns else f"{name}_component")
        return dims, value, self.attributes[name]

    def dataset(
        self,
        result: Result,
        u0: Displacements,
        v0: Displacements,
        dt: PerRun,
        steps: CountPerRun,
        every: int,
        samples: int,
        ensemble: bool,
    ) -> xr.Dataset:
        """The result as the dataset that :func:`study.run` returns.

        Parameters
        ----------
        result
            Result of the march, with NumPy arrays that no other code uses.
        u0, v0, dt, steps
            Initial displacement and velocity, step size and number of steps, each with or without an axis of lanes.
        every, samples
            Number of steps between two samples, and number of samples after the first one.
        ensemble
            Whether the arrays have an axis of lanes in front.
        """
        lane = ("lane",) if ensemble else ()
        failed = result.status != COMPLETED
        values: dict[str, np.ndarray] = {
            "status": result.status.astype(np.int32),
            "failed_at_step": result.failed_at_step,
            "newton_restarts": result.restarts,
        }
        values |= {name: nan_where(failed, value) for name, value in result.values.items()}
        ends_early = failed.any() or samples * every > steps.min()
        for name, value in result.samples.items():
            if ends_early:
                value[_without_meaning(result, steps, every, samples)] = np.nan
            values[name] = value
        arguments = {"dt": dt, "steps": steps, "u0": u0, "v0": v0}
        by_lane = {n: v for n, v in arguments.items() if v.ndim > (len(self._component) if n in ("u0", "v0") else 0)}
        shared = {n: v[()] for n, v in arguments.items() if n not in by_lane and v.size <= MOST_IN_ATTRIBUTE}
        along = "sample" if dt.ndim else "t"
        data = {}
        for name, value in values.items():
            data[name] = self.variable(name, value, (*lane, along) if name in result.samples else lane)
        coordinates: dict[str, tuple] = {
            name: ((*lane, *self._component[: value.ndim - 1]), value, LANE_ATTRIBUTES[name])
            for name, value in by_lane.items()
        }
        if samples:
            t = np.multiply.outer(dt, np.arange(samples + 1) * every)
            coordinates["t"] = ((*lane, "sample") if dt.ndim else "t", t, {"long_name": "elapsed time", "units": "s"})
        return xr.Dataset(data, coordinates, self.dataset_attributes | shared)
