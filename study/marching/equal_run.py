"""Runs with equal steps, as a labelled dataset, or as parts of an ensemble in files."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import numpy as np
import xarray as xr
from tqdm import tqdm

from study.marching import failure, stability
from study.marching.arguments import check_memory, positive_integer
from study.marching.ensemble import FEW, march_in_tiles, march_one_by_one
from study.marching.failure import SILENT
from study.marching.march import March
from study.marching.parts import Lane, Parts
from study.marching.program import Program
from study.marching.result import COMPLETED, NO_SOLUTION, NOT_FINITE, Labels, Result
from study.marching.shapes import CountPerRun, Displacements, PerRun
from study.mechanics.definition import Problem
from study.mechanics.function_checks import NOT_TRACEABLE
from study.mechanics.function_checks import failure as trace_failure
from study.observer.base import Observer, Record
from study.scheme.base import Scheme
from study.warn import warn

#: Largest number of samples × lanes × unknowns whose records fit into the memory of any machine.
ANY_MEMORY = 10_000_000

#: Minimum of steps × unknowns of a run that shows a progress bar.
LONG = 2**24


class EqualSteps:
    """A single run with equal steps, or an ensemble of such runs.

    Parameters
    ----------
    problem, scheme, observers
        What is run; ``problem`` is that of the first lane.
    starts
        Initial displacement and velocity, of one run or of all lanes.
    dt, steps, every, samples, bound, on_failure
        As in :func:`study.run`, checked.
    make
        The function that makes the problem of a lane from its arguments, or None.
    values
        Values (lanes, ...) of each of its arguments.
    lanes
        Number of lanes, 0 for a single run.
    """

    def __init__(
        self,
        problem: Problem,
        scheme: Scheme,
        observers: tuple[Observer, ...],
        starts: tuple[Displacements, Displacements],
        dt: PerRun,
        steps: CountPerRun,
        every: int,
        samples: int | None,
        make: Callable | None,
        values: dict[str, np.ndarray],
        lanes: int,
        bound: float,
        on_failure: str,
    ):
        self._problem, self._scheme, self._observers = problem, scheme, observers
        self._starts, self._dt, self._steps, self._every = starts, dt, steps, every
        self._make, self._values, self._lanes, self._bound = make, values, lanes, bound
        self._on_failure = on_failure
        self._few = lanes <= FEW and np.ndim(problem.u0) > 0 and not values and jax.default_backend() == "cpu"
        self._watches = on_failure != SILENT and stability.has_limit(scheme, problem)
        self._march = self._march_of(problem)
        self._room = _samples(self._march.records, steps, every, samples)

    def _march_of(self, problem: Problem) -> March:
        observed = (*self._observers, stability.AtStart()) if self._watches else self._observers
        side_by_side = bool(self._lanes) and not self._few
        return March.of(
            problem, self._scheme, observers=observed, lanes=side_by_side, bound=self._bound, make=self._make
        )

    def dataset(self, part: slice = slice(None)) -> xr.Dataset:
        """March the lanes of a part, or all of them, or the single run, and label the result."""
        u0, v0 = (x[part] if x.ndim > np.ndim(self._problem.u0) else x for x in self._starts)
        dt, steps = (x[part] if x.ndim else x for x in (self._dt, self._steps))
        values = {name: value[part] for name, value in self._values.items()}
        begin = u0, v0
        if self._lanes:
            shape = (len(range(self._lanes)[part]), *np.shape(self._problem.u0))
            begin = np.broadcast_to(u0, shape), np.broadcast_to(v0, shape)
        _check_memory(self._march.with_arguments(values), *begin, dt, self._room)
        result = self._marched(begin, dt, steps, values)
        motion = stability.taken_from(result.values) if self._watches else None
        if self._on_failure != SILENT:
            self._report_failures(result, None if values else begin, dt, motion, part.start or 0)
        if motion is not None:
            _report_excess(result, self._scheme, motion, dt, steps, part.start or 0)
        labels = Labels(self._problem, self._scheme, self._observers)
        ds = labels.dataset(result, u0, v0, dt, steps, self._every, self._room, bool(self._lanes))
        if not values:
            return ds
        for first_lane in ("u0", "v0"):
            ds.attrs.pop(first_lane, None)
        return ds.assign_coords(
            {name: (("lane", *(f"{name}_{axis}" for axis in range(1, x.ndim))), x) for name, x in values.items()}
        )

    def _marched(
        self,
        begin: tuple[Displacements, Displacements],
        dt: PerRun,
        steps: CountPerRun,
        values: dict[str, np.ndarray],
    ) -> Result:
        """March the lanes, or the single run, and those whose equations were not solved again with a safeguard."""

        def marched(march: March, place: Any = slice(None)) -> Result:
            """March the lanes at ``place``, or the single run."""
            program = Program(march)
            if not self._lanes:
                return _march_alone(program, *begin, dt, int(steps), self._every, self._room)
            march_lanes = march_one_by_one if self._few else march_in_tiles
            starts = begin[0][place], begin[1][place], dt[place] if dt.ndim else dt
            arguments = {name: value[place] for name, value in values.items()}
            counts = steps[place] if steps.ndim else steps
            return march_lanes(program, (*starts, arguments), counts, self._every, self._room)

        result = _traced(bool(values), marched, self._march)
        unsolved = result.status == NO_SOLUTION
        if not (self._scheme.explicit or self._problem.linear):  # a correction may end where the force is not finite
            unsolved |= result.status == NOT_FINITE
        if not unsolved.any():
            return result
        again = marched(self._march_of(self._problem.with_safeguard()), unsolved)
        return jax.tree.map(lambda all_, new: _replaced(all_, unsolved, new), result, again) if self._lanes else again

    def _report_failures(
        self, result: Result, begin: tuple | None, dt: PerRun, motion: stability.SmallMotion | None, first_lane: int
    ) -> None:
        """Warn of failed runs, raise an error, or do nothing."""
        if self._on_failure != "ignore" and np.any(result.status):
            message = failure.sentence(result, self._problem, self._scheme, begin, dt, motion, first_lane)
            if self._on_failure == "raise":
                raise RuntimeError(message)
            warn(message, failure.RunFailedWarning)

    def written(self, save: str | Path | Parts) -> xr.Dataset:
        """The parts of the ensemble in files, opened as one dataset.

        Raises
        ------
        ValueError
            If this is a single run, or as :meth:`study.marching.parts.Parts.written`.
        """
        if not self._lanes:
            raise ValueError("save writes the parts of an ensemble; a single run is written by its method to_netcdf.")
        (u0, v0), n = self._starts, np.ndim(self._problem.u0)
        first = (x[0] if x.ndim > ndim else x for x, ndim in ((u0, n), (v0, n), (self._dt, 0)))
        whole = {"u0": u0, "v0": v0, "dt": self._dt, "steps": self._steps, "every": self._every, "samples": self._room}
        lane = _traced(
            bool(self._values),
            Lane.traced,
            partial(March.of, scheme=self._scheme, observers=self._observers, bound=self._bound),
            self._make or (lambda: self._problem),
            (*first, {name: value[0] for name, value in self._values.items()}),
            self._room + 1,
            whole | self._values,
        )
        parts = save if isinstance(save, Parts) else Parts(save)
        return parts.written(self.dataset, self._lanes, lane)


def _march_alone(
    program: Program, u0: Displacements, v0: Displacements, dt: PerRun, steps: int, every: int, samples: int
) -> Result:
    """March a single run, with a progress bar in a terminal if it is long."""
    if steps * u0.size < LONG:
        return program.run(u0, v0, dt, steps, every, samples)
    with tqdm(total=steps, disable=None, leave=False) as bar:

        def show(step):
            bar.update(step - bar.n)
            return True

        return program.run(u0, v0, dt, steps, every, samples, on_pause=show)


def _samples(records: Sequence[Record], steps: CountPerRun, every: int, samples: int | None) -> int:
    """Number of samples to store after the first one; zero without records."""
    if records and steps.ndim:
        raise ValueError(
            f"'{next(iter(records[0].variables))}' is recorded along time, which needs one number of steps for all "
            "lanes: give steps as a number, or observe quantities with one value per run."
        )
    if samples is None and np.any(steps % every):
        raise ValueError(f"every must divide the number of steps; {every} does not divide {steps[()]}.")
    if not records:
        return 0
    return int(steps) // every if samples is None else positive_integer("samples", samples)


def _check_memory(march: March, u0: Displacements, v0: Displacements, dt: PerRun, samples: int) -> None:
    """Refuse records that exceed the memory; their shapes follow from the first sample, which is not computed."""
    if (samples + 1) * u0.size <= ANY_MEMORY:
        return
    one_by_one = u0.ndim > np.ndim(march.problem.u0) and not march.lanes
    lane = (u0[0], v0[0], dt.ravel()[0]) if one_by_one else (u0, v0, dt)
    _, _, stored = eqx.filter_eval_shape(march.start, *lane, 1)
    lanes = u0.size // lane[0].size
    check_memory({name: lanes * math.prod(a.shape[1:]) * a.dtype.itemsize for name, a in stored.items()}, samples + 1)


def _traced(family: bool, trace: Callable, *arguments: Any) -> Any:
    """The value of a function that traces a march.

    An error has no traceback through the march; in a family, it names the function that makes the problems.
    """
    try:
        return trace(*arguments)
    except NOT_TRACEABLE as error:
        if not family:
            raise
        raise ValueError(
            "the function that makes the problem of each lane, in which a sparse matrix that depends on its arguments "
            f"is a jax.experimental.sparse.BCOO, {trace_failure(error, 'fails')}"
        ) from error
    except TypeError as error:  # a scheme or an observer raised it
        raise error.with_traceback(None) from error.__cause__


def _replaced(values: np.ndarray, place: np.ndarray, new: np.ndarray) -> np.ndarray:
    values = np.array(values)
    values[place] = new
    return values


def _report_excess(
    result: Result, scheme: Scheme, motion: stability.SmallMotion, dt: PerRun, steps: CountPerRun, first_lane: int
) -> None:
    """Warn if runs have completed with steps beyond the stability limit; name the lane that is farthest beyond it."""
    excess = np.where(result.status == COMPLETED, stability.excess(scheme, motion, dt, steps), 0.0)
    if excess.any():
        lane = int(np.argmax(excess))
        step_size = float(np.broadcast_to(dt, excess.shape).ravel()[lane])
        where = f" in lane {first_lane + lane}" if np.ndim(excess) else ""
        message = stability.sentence(scheme, motion.matrices_of_lane(lane), step_size, where)
        warn(f"{message}; the run has completed, but its results may be wrong.")
