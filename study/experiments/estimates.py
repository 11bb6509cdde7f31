"""Estimates of the error of a step, compared with the true error."""

import math
from collections.abc import Callable
from typing import Any

import equinox as eqx
import numpy as np
import xarray as xr

from study.control.controllers import Prescribed
from study.control.leading import linear_ratio
from study.control.named import estimators as estimators_by_name
from study.declaration.experiment import experiment, progress
from study.declaration.options import Counts, Estimators, Problems, Schemes
from study.experiments import coordinates
from study.marching.run import run
from study.mechanics.definition import Problem
from study.problem.inelastic import PERIOD
from study.problem.named import approximate_periods, time_scales
from study.problem.named import problems as problems_by_name
from study.scheme.embedded_nystrom import dormand_prince6
from study.scheme.named import schemes as schemes_by_name
from study.scheme.runge_kutta import rk4

#: Schemes that compute the true motion over one step of the tested scheme, for undamped and for damped problems.
UNDAMPED, DAMPED = dormand_prince6, rk4

#: Smallest number of fine steps in one step of the tested scheme, and in one period of the stiffest mode.
FINE_STEPS = 16

#: Number of periods of the stiffest mode in the time scale of each stiff problem.
STIFFEST = {"stiff_soft": 2635, "stiff_soft_sine": 2635, "elastic_pendulum": 7086}

#: Phases, as fractions of the period, at which ``ratio`` is given.
PHASES = np.linspace(0, 1, 101)


def _fine_steps(problem: str, steps: int) -> int:
    """Number of fine steps for the true motion over one step of a scheme that takes ``steps`` steps per period."""
    return math.ceil(FINE_STEPS * max(1.0, STIFFEST.get(problem, 0) / steps))


@experiment(
    "estimates",
    reads=lambda options: [f"reference/{problem}" for problem in options["problems"] if problem in approximate_periods],
)
def estimates(problems: Problems, schemes: Schemes, estimators: Estimators, steps_per_period: Counts) -> xr.Dataset:
    """Measure estimates of the error of a step over one period, next to the true error.

    The true error of a step is its difference from the true motion with the same start. The true motion is computed
    with at least 16 steps of Dormand and Prince's method of sixth order, or of the classical Runge-Kutta method if the
    problem is damped. ``true_error`` is the larger of the errors of displacement and velocity, each relative to its
    largest value. ``true_displacement_error`` ignores the velocity, as does the estimate of Zienkiewicz and Xie. The
    estimates are relative to the largest values so far. ``estimate`` and both errors are the largest values in the
    period without its first tenth. ``ratio`` is the estimate divided by the true error, along the period, at the
    smallest step size. ``linear_ratio`` is the closed form of this ratio for a linear undamped oscillator that starts
    from a displacement (:mod:`study.control.leading`). It is NaN without a closed form. For a structure, its time scale
    takes the place of the period. Problems with a history are left out (NaN), because their motion cannot start again
    within a run.
    """
    shape = (len(problems), len(schemes), len(estimators), len(steps_per_period))
    estimate, true, displacement = (np.full(shape, np.nan) for _ in range(3))
    ratio = np.full((*shape[:3], len(PHASES)), np.nan)
    for p, problem in enumerate(problems):
        equations = problems_by_name[problem]
        if equations.history is not None:
            continue
        period = _period(problem)
        for s, scheme in enumerate(schemes):
            progress(f"estimates for {scheme} on {problem}")
            for k, steps in enumerate(steps_per_period):
                errors = None
                for e, estimator in enumerate(estimators):
                    if estimators_by_name[estimator].refusal(schemes_by_name[scheme], equations) is not None:
                        continue
                    dt = period / steps
                    equal = Prescribed(np.array([dt]))
                    ds = run(equations, scheme, controller=equal, duration=period, estimator=estimator)
                    if errors is None or estimator == "step_doubling":
                        errors = true_errors(equations, ds, _fine_steps(problem, steps))
                    displacement_error, state_error = errors
                    late = ds.t.values[1:] > 0.1 * period
                    at = p, s, e, k
                    estimate[at] = ds.estimate.values[1:][late].max()
                    displacement[at], true[at] = displacement_error[late].max(), state_error[late].max()
                    if steps == max(steps_per_period):
                        middle = (ds.t.values[1:] - dt / 2) / period
                        ratio[at[:3]] = np.interp(PHASES, middle, ds.estimate.values[1:] / state_error)
    closed = [
        [linear_ratio(schemes_by_name[scheme], name, PHASES, max(steps_per_period)) for name in estimators]
        for scheme in schemes
    ]
    dims = ("problem", "scheme", "estimator", "steps_per_period")
    largest = "largest in a period after its first tenth"
    return xr.Dataset(
        {
            "estimate": (dims, estimate, {"long_name": f"estimate of the error of a step, {largest}", "units": "1"}),
            "true_error": (dims, true, {"long_name": f"true error of a step, {largest}", "units": "1"}),
            "true_displacement_error": (
                dims,
                displacement,
                {"long_name": f"true error of the displacement of a step, {largest}", "units": "1"},
            ),
            "ratio": (
                (*dims[:3], "phase"),
                ratio,
                {"long_name": "estimate over true error at the smallest step", "units": "1"},
            ),
            "linear_ratio": (
                ("scheme", "estimator", "phase"),
                np.array(closed),
                {"long_name": "closed form of that ratio for a linear oscillator", "units": "1"},
            ),
        },
        coords={
            **coordinates.problem_coordinates(problems),
            **coordinates.scheme_coordinates(schemes),
            **coordinates.estimator_coordinates(estimators),
            **coordinates.steps_per_period_coordinate(steps_per_period),
            "phase": ("phase", PHASES, {"long_name": "part of the period", "units": "1"}),
        },
        attrs={"title": "Estimates of the error of a step and the true error"},
    )


def _period(problem: str) -> float:
    """Exact period of a spring, or the time scale of another problem."""
    if problem in approximate_periods:
        return coordinates.periods(problem)["exact"]
    return time_scales.get(problem, PERIOD)


class _Later(eqx.Module):
    """A load whose time is counted from a later start."""

    load: Callable
    start: float

    def __call__(self, t):
        return self.load(self.start + t)


def true_errors(problem: Problem, ds: xr.Dataset, steps: int = FINE_STEPS) -> tuple[np.ndarray, np.ndarray]:
    """True errors of each step, relative to the largest values.

    The first array has the errors of the displacement. The second has the larger of the errors of displacement and
    velocity in each step.
    """
    u, v, h = ds.u.values, ds.v.values, ds.step_size.values[1:]
    scheme = UNDAMPED if problem.damping is None else DAMPED
    fine: dict[str, Any] = {"dt": h / steps, "steps": steps, "every": steps}
    load = problem.load
    if load is None:
        true = run(problem, scheme, u0=u[:-1], v0=v[:-1], **fine)
    else:

        def restarted(now, here, speed):
            later = _Later(load, now)
            return eqx.tree_at(lambda p: (p.u0, p.v0, p.load), problem, (here, speed, later))

        true = run(restarted, scheme, over={"now": ds.t.values[:-1], "here": u[:-1], "speed": v[:-1]}, **fine)
    displacement, velocity = (
        _size(numerical[1:] - exact.values[:, -1]) / _size(numerical).max()
        for numerical, exact in ((u, true.u), (v, true.v))
    )
    return displacement, np.maximum(displacement, velocity)


def _size(values: np.ndarray) -> np.ndarray:
    """Euclidean norm over the unknowns, along time."""
    return np.linalg.norm(values.reshape(len(values), -1), axis=1)
