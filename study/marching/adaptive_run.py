"""A run with a controlled step size, as a labelled dataset."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from jax import lax

from study.algebra.deadline import check_time
from study.algebra.jit import jit
from study.control.estimators import Sizes
from study.io import flags
from study.marching import kernel
from study.marching.adaptive import (
    RUNNING,
    STEP_ARRAY,
    STEP_TOO_SMALL,
    STEP_VALUES,
    TOO_MANY_STEPS,
    AdaptiveMarch,
    Trial,
    proceed,
)
from study.marching.control import Control
from study.marching.failure import HOW, RunFailedWarning, cause_of_derivative, likely_cause
from study.marching.march import March
from study.marching.program import PAUSE, ROOM, unlabelled
from study.marching.result import COMPLETED, FAILED_AT_STEP_ATTRIBUTES, STATUSES, Labels, nan_where
from study.marching.shapes import Displacements, PerRun
from study.mechanics.definition import Problem
from study.mechanics.state import Effort
from study.observer.base import Observer
from study.observer.energy import ChangeOfEnergy
from study.scheme.base import Scheme
from study.scheme.bathe import bathe
from study.scheme.contract import started, stepped
from study.scheme.wrapper.unequal_steps import UnequalSteps
from study.scheme.wrapper.with_history import WithHistory
from study.warn import warn
from study.words import percent

#: Maximum number of samples of one run that are stored by one call of the compiled program.
MOST_ROOM = 2**15

#: Number of equal parts of a trial run, which measures the sizes of a motion if one of them is zero at the start. Its
#: scheme dissipates energy, because a size that grows in an unresolved contact would loosen every tolerance.
TRIAL_STEPS = 200

#: Change of a constant energy during a run of which a warning is given, as a fraction of the largest kinetic energy.
LARGE_CHANGE = 0.1

#: Meanings of the status of a run with a controlled step size.
ENDS = (*STATUSES, "step_too_small", "too_many_steps")

_STATUS = flags("how the run ended", ENDS, np.int32)

_HOW = {
    **HOW,
    STEP_TOO_SMALL: "the step shrank to nothing, as at a jump of the force or a motion that grows without bound",
    TOO_MANY_STEPS: "it reached the largest number of steps before its end",
}

_STEP_ATTRIBUTES = {
    "step_size": {"long_name": "size of the step that ends here", "units": "s"},
    "estimate": {"long_name": "estimate of the error of that step", "units": "1"},
    "rejected_by_estimate": {"long_name": "trial steps before it that the estimate rejected", "units": "1"},
    "rejected_by_solver": {"long_name": "trial steps before it without balance or finite state", "units": "1"},
}

_TRIAL_RUN = {"trial_run_force_evaluations": {"long_name": "forces of the run that measures the sizes", "units": "1"}}

_RUN_ATTRIBUTES = {
    "steps": {"long_name": "number of steps", "units": "1"},
    "steps_rejected_by_estimate": {"long_name": "trial steps that the estimate rejected", "units": "1"},
    "steps_rejected_by_solver": {"long_name": "trial steps without balance or finite state", "units": "1"},
    "failed_at_time": {"long_name": "time at which the run failed, NaN where it did not", "units": "s"},
}


def _start(march: March, starts: tuple) -> tuple[jax.Array, jax.Array]:
    return starts or (jnp.asarray(march.problem.u0), jnp.asarray(march.problem.v0))


@partial(jit, compiler=eqx.filter_jit)
def _begin(march_of, lanes: bool, adaptive, arguments, starts, dt, tolerance, room: int):
    def lane_start(arguments, starts, dt, tolerance):
        march = march_of(adaptive, arguments)
        return march.begin(*_start(march.march, starts), dt, tolerance, room)

    return (jax.vmap(lane_start) if lanes else lane_start)(arguments, starts, dt, tolerance)


@partial(jit, compiler=eqx.filter_jit)
def _scales_of_trial(march_of, lanes: bool, adaptive, arguments, starts, grid) -> tuple[Sizes, Effort]:
    """Largest value of each size of the motion in a run with steps to the times of a grid, and the effort of the run.

    A value that is not finite becomes zero. The times of the load are among those of the grid, because otherwise the
    run could step over a pulse.
    """

    def lane_scales(arguments, starts):
        march = march_of(adaptive, arguments)
        problem = march.march.problem
        scheme = bathe if problem.history is None else WithHistory(scheme=bathe)

        def step(carry, ends):
            state, largest, effort = carry
            state, step_effort = stepped(scheme, problem.at(state), state, ends[0], ends[1] - ends[0])
            sizes = march.estimator.sizes(problem.at(state).at_time(ends[1]), state)
            return (state, tuple(map(jnp.maximum, largest, sizes)), effort.then(step_effort.trial_effort())), None

        state, effort = started(scheme, problem, *_start(march.march, starts), grid[1])
        begin = state, march.estimator.sizes(problem.at(state).at_time(0.0), state), effort.trial_effort()
        (_, largest, effort), _ = lax.scan(step, begin, jnp.stack([grid[:-1], grid[1:]], axis=1))
        return tuple(jnp.where(jnp.isfinite(size), size, 0.0) for size in largest), effort

    return (jax.vmap(lane_scales) if lanes else lane_scales)(arguments, starts)


@partial(jit, compiler=eqx.filter_jit)
def _proceed(march_of, lanes: bool, adaptive, arguments, trial, stored, initial, tolerance, room: int, turns):
    trial, stored = proceed(
        partial(march_of, adaptive), lanes, arguments, trial, stored, initial, tolerance, room, turns
    )

    def result(arguments, trial):
        return march_of(adaptive, arguments).result(trial)

    return trial, stored, (jax.vmap(result) if lanes else result)(arguments, trial)


def _itself(adaptive: AdaptiveMarch, arguments: Any) -> AdaptiveMarch:
    return adaptive


class _Family(eqx.Module):
    """Function that gives a march, which has no problem, the one that ``make`` returns for a lane's arguments."""

    make: Callable = eqx.field(static=True)

    def __call__(self, adaptive: AdaptiveMarch, arguments: dict) -> AdaptiveMarch:
        problem = self.make(**arguments)
        return eqx.tree_at(lambda a: a.march.problem, adaptive, problem, is_leaf=lambda x: x is None)


def _joined(parts: Sequence[tuple[np.ndarray, dict]], lanes: bool) -> dict[str, np.ndarray]:
    """The samples of all calls, joined along time in each lane; shorter lanes are padded with NaN.

    Each part is a pair for one call: the number of its samples, in each lane if there are lanes, and the samples.
    """
    if not parts:
        return {}
    names = list(parts[0][1])
    if not lanes:
        return {name: np.concatenate([part[name][:n] for n, part in parts]) for name in names}
    longest = int(np.sum([n for n, _ in parts], axis=0).max())
    whole = {}
    for name in names:
        first = parts[0][1][name]
        whole[name] = np.full((first.shape[0], longest, *first.shape[2:]), np.nan)
        for lane in range(first.shape[0]):
            values = np.concatenate([part[name][lane, : n[lane]] for n, part in parts])
            whole[name][lane, : len(values)] = values
    return whole


class Adaptive:
    """A run with a controlled step size: the march, and the labels of its result.

    Parameters
    ----------
    problem
        The problem; for a family of problems, the problem of the first lane.
    starts
        Initial displacement and velocity, of one run or of all lanes.
    make, over
        For a family of problems: the function that makes the problem of a lane, and its arguments; otherwise None and
        empty.
    lanes
        Number of lanes, 0 for a single run.
    bound
        Displacement beyond which a run ends as unbounded.
    watches_energy
        Whether a warning states how much of the energy, which must be constant, is lost.
    """

    def __init__(
        self,
        problem: Problem,
        scheme: Scheme,
        observers: Sequence[Observer],
        starts: tuple[Displacements, Displacements],
        make: Callable[..., Problem] | None,
        over: dict[str, np.ndarray],
        lanes: int,
        bound: float,
        watches_energy: bool,
    ):
        self._problem, self._scheme, self._lanes, self._over = problem, scheme, lanes, over
        method = scheme
        if scheme.acceleration_offset and not isinstance(scheme, UnequalSteps):
            method = UnequalSteps(scheme=scheme)
        observed = (*observers, ChangeOfEnergy()) if watches_energy else observers
        self._march = unlabelled(March.of(self._problem, method, observed, bool(lanes), bound))
        self._march_of = _itself if make is None else _Family(make)
        if make is not None:  # a problem that is made again has new functions, which would be compiled again
            self._march = eqx.tree_at(lambda march: march.problem, self._march, None)
        if self._march.in_kernels:
            kernel.report("takes equal steps only")
        shape = (lanes, *np.shape(self._problem.u0))
        self._starts = () if make else tuple(np.broadcast_to(x, shape) if lanes else x for x in starts)
        self._labels = Labels(self._problem, scheme, observers)
        self._labels.attributes |= _STEP_ATTRIBUTES | _TRIAL_RUN

    def dataset(self, control: Control, on_failure: str) -> xr.Dataset:
        """March to the end, and label the result."""
        tolerance, dt = (np.broadcast_to(x, self._lanes) if self._lanes else x for x in (control.tolerance, control.dt))
        trial, samples, values = self._marched(control, tolerance, dt)
        status = np.asarray(trial.status).astype(np.int32)
        failed, steps, t = status != COMPLETED, np.asarray(trial.steps), np.asarray(trial.t)
        if on_failure != "ignore" and failed.any():
            self._report_failures(trial, on_failure)
        if "change_of_energy" in values:
            change, largest = (np.where(failed, 0.0, values.pop(name)) for name in ChangeOfEnergy.variables)
            self._report_energy(change, largest, control)
        lane = ("lane",) if self._lanes else ()
        data: dict[str, Any] = {
            "status": (lane, status, _STATUS),
            "failed_at_step": (lane, np.where(failed, steps + 1, -1), FAILED_AT_STEP_ATTRIBUTES),
            "failed_at_time": (lane, np.where(failed, t, np.nan), _RUN_ATTRIBUTES["failed_at_time"]),
            "steps": (lane, steps, _RUN_ATTRIBUTES["steps"]),
        }
        for cause, total in (("estimate", trial.estimated), ("solver", trial.unsolved)):
            name = f"steps_rejected_by_{cause}"
            data[name] = (lane, np.asarray(total), _RUN_ATTRIBUTES[name])
        data |= {name: self._labels.variable(name, nan_where(failed, value), lane) for name, value in values.items()}
        coordinates: dict[str, Any] = {n: ("lane", x) for n, x in self._over.items() if x.ndim == 1}
        if samples:
            samples |= dict(zip(STEP_VALUES, np.moveaxis(samples.pop(STEP_ARRAY), -1, 0), strict=True))
            along = (*lane, "sample" if self._lanes else "t")
            coordinates["t"] = (along, samples.pop("t"), {"long_name": "elapsed time", "units": "s"})
            for name in ("rejected_by_estimate", "rejected_by_solver"):
                samples[name] = np.diff(samples[name], axis=-1, prepend=0)
            data |= {name: self._labels.variable(name, value, along) for name, value in samples.items()}
        named: dict[str, str | float] = {"estimator": control.estimator.title, "controller": control.controller.title}
        named["duration"] = float(control.times[-1])
        if control.tolerance.ndim:
            coordinates["tolerance"] = ("lane", tolerance, {"long_name": "tolerance", "units": "1"})
        elif control.controller.needs_tolerance:
            named["tolerance"] = float(control.tolerance)
        return xr.Dataset(data, coordinates, self._labels.dataset_attributes | named)

    def _marched(
        self, control: Control, tolerance: PerRun, dt: PerRun
    ) -> tuple[Trial, dict[str, np.ndarray], dict[str, np.ndarray]]:
        """March to the end: the last :class:`Trial`, the samples, and the results of the reductions."""
        lanes = bool(self._lanes)
        times, most = jnp.asarray(control.times), jnp.asarray(control.steps)
        adaptive = AdaptiveMarch(self._march, control.estimator, control.controller, times, most)
        unknowns, several = np.size(self._problem.u0), max(self._lanes, 1)
        keeps = bool(self._march.records) or not lanes
        room = max(16, min(MOST_ROOM, ROOM // (unknowns * several))) if keeps else 0
        turns = max(1, int(PAUSE / 8 / (several * unknowns**1.5)))
        begin = self._march_of, lanes, adaptive, self._over, self._starts
        trial, initial, stored = _begin(*begin, dt, tolerance, room)
        measuring = np.zeros(self._lanes or (), int)
        if control.estimator.relative and not all(np.all(np.asarray(size)) for size in trial.scales):
            # estimates are relative to sizes of the motion so far, and at least one size is zero at the start
            grid = np.union1d(np.linspace(0.0, control.times[-1], TRIAL_STEPS + 1), control.times)
            scales, effort = _scales_of_trial(*begin, grid)
            trial = trial._replace(scales=tuple(map(jnp.maximum, trial.scales, scales)))
            measuring = np.asarray(effort.forces)
        parts = []
        while True:
            trial, stored, values = _proceed(
                self._march_of, lanes, adaptive, self._over, trial, stored, initial, tolerance, room, turns
            )
            ended = np.all(np.asarray(trial.status) != RUNNING)
            if keeps and (ended or np.any(np.asarray(trial.place) >= room)):
                parts.append((np.asarray(trial.place), {n: np.asarray(x) for n, x in stored.items()}))
                trial = trial._replace(place=jnp.zeros_like(trial.place))
            if ended:
                results = {n: np.asarray(x) for n, x in values.items()}
                results |= dict.fromkeys(_TRIAL_RUN, measuring) if "force_evaluations" in results else {}
                return trial, _joined(parts, lanes), results
            check_time()

    def _report_energy(self, change: np.ndarray, largest: np.ndarray, control: Control) -> None:
        """Warn if runs have lost or gained a large part of an energy that must be constant; name the worst lane."""
        part = np.ravel(np.divide(change, largest, out=np.zeros_like(change), where=largest > 0))
        worst = int(np.abs(part).argmax())
        if abs(part[worst]) <= LARGE_CHANGE:
            return
        tolerance = float(np.broadcast_to(control.tolerance, part.shape)[worst])
        lane = f" in lane {worst}" if self._lanes else ""
        smaller = f"a tolerance below {tolerance:g}" if control.controller.needs_tolerance else "smaller steps"
        warn(
            f"'{self._scheme.title}' has {'gained' if part[worst] > 0 else 'lost'} energy of "
            f"'{self._problem.title}'{lane}, where nothing supplies or dissipates any: "
            f"{percent(abs(part[worst]))} of the largest kinetic energy; take {smaller}, or another scheme."
        )

    def _report_failures(self, trial: Trial, on_failure: str) -> None:
        """Warn of failed runs, or raise an error."""
        status = np.asarray(trial.status)
        failed = np.flatnonzero(status)
        first = failed[0]
        code, step, at, size = (np.ravel(x)[first] for x in (status, trial.steps, trial.t, trial.dt))
        many = f"{failed.size} of {status.size} runs failed, the first of them, lane {first}: " if status.ndim else ""
        cause = ""
        if not (self._over or self._scheme.explicit):
            state = jax.tree.map(lambda x: x[first], trial.state) if self._lanes else trial.state
            usual = max(float(size), float(at) / max(int(step), 1))  # the size may have shrunk before the failure
            cause = cause_of_derivative(self._problem.at(state), float(at), state.u, state.v, usual)
        if not cause and code < STEP_TOO_SMALL:
            cause = likely_cause(self._problem, self._scheme, int(code), float(size))
        message = (
            f"{many}'{self._scheme.title}' failed on '{self._problem.title}' after {step} steps, at t = {at:.6g}, with "
            f"dt = {size:.6g}: {_HOW[int(code)]}." + (f" Likely cause: {cause}" if cause else "")
        )
        if on_failure == "raise":
            raise RuntimeError(message)
        warn(message, RunFailedWarning)
