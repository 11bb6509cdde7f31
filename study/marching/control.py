"""Checks of the arguments that choose the steps of a run with a tolerance."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from study.algebra.arrays import real_numbers
from study.algebra.scalars import is_number
from study.control.controllers import Controller, Prescribed
from study.control.end_of_step import WithEnd
from study.control.estimators import Estimator, Unestimated
from study.control.named import controllers, estimators
from study.marching.arguments import checked_step_size, positive_integer, resolve
from study.marching.shapes import PerRun
from study.mechanics.definition import Problem
from study.observer.base import Observer
from study.scheme.base import Scheme

#: Default size of the first step, as a fraction of the duration.
FIRST_STEP = 1e-3

#: Default of the largest number of steps.
MOST_STEPS = 1_000_000


class Control(NamedTuple):
    """Settings that determine the steps of a run.

    Attributes
    ----------
    tolerance, dt
        Tolerance and size of the first step, each of shape () or (lanes,).
    times
        Times at which a step must end; the last one ends the run.
    steps
        Largest number of steps.
    """

    estimator: Estimator
    controller: Controller
    tolerance: PerRun
    dt: PerRun
    times: np.ndarray
    steps: int


def usual_estimator(scheme: Scheme, problem: Problem) -> str:
    """Name of the default estimator: the first one in a list that accepts the scheme and the problem.

    The list holds the embedded pair, Zienkiewicz-Xie if the scheme has an ``acceleration_offset``, and step doubling.
    """
    carries = scheme.acceleration_offset is not None
    fits = ["embedded_pair", *(["zienkiewicz_xie"] if carries else []), "step_doubling"]
    return next(name for name in fits if not estimators[name].refusal(scheme, problem))


def with_end(estimator: Estimator, scheme: Scheme, problem: Problem) -> Estimator:
    """The estimator, with the force at the end of a step if the scheme evaluates none there, or its slope may jump.

    A linear structure meets no contact, and the other estimates see a smooth force that is evaluated at the end.
    """
    seen = (scheme.force_at_end and not problem.kinked) or problem.linear or isinstance(estimator, WithEnd)
    return estimator if seen else WithEnd(estimator)


def checked_control(
    problem: Problem,
    scheme: Scheme,
    observers: Sequence[Observer],
    estimator: Any,
    controller: Any,
    tolerance: Any,
    duration: Any,
    times: Any,
    dt: Any,
    steps: Any,
    load_times: Callable[[float], np.ndarray],
) -> Control:
    """Settings that determine the steps of a run, from the arguments of :func:`study.run`.

    Parameters
    ----------
    load_times
        Function that returns the times of the load within a duration at which steps must end.

    Raises
    ------
    KeyError, TypeError, ValueError
        If there is no such estimator or controller, if the estimator does not fit the scheme or the problem, if the
        scheme or an observer needs equal steps, or if a number is missing or out of its range.
    """
    if scheme.needs_equal_steps:
        raise ValueError(
            f"'{scheme.title}' needs steps of one size, because its state depends on this size: give dt and steps."
        )
    for observer in observers:
        if observer.needs_equal_steps:
            raise ValueError(f"{', '.join(observer.variables)} needs steps of one size: give dt and steps.")
    control: Controller = resolve("pi" if controller is None else controller, controllers, Controller)  # type: ignore[type-abstract]
    if estimator is None and not control.needs_tolerance:
        if tolerance is not None:
            raise ValueError(f"the controller '{control.title}' takes no tolerance without an estimator; leave it out.")
        estimator = Unestimated()
    elif estimator is None:
        estimator = usual_estimator(scheme, problem)
    chosen: Estimator = resolve(estimator, estimators, Estimator)  # type: ignore[type-abstract]
    if reason := chosen.refusal(scheme, problem):
        raise ValueError(reason)
    if not control.sizes_are_given:
        chosen = with_end(chosen, scheme, problem)
    if tolerance is None and control.needs_tolerance:
        raise ValueError(f"the controller '{control.title}' needs a tolerance.")
    values = np.asarray(1.0) if tolerance is None else real_numbers("tolerance", tolerance)
    smallest = np.finfo(float).eps
    if values.ndim > 1 or not values.size or not np.all(np.isfinite(values) & (values > smallest)):
        raise ValueError(f"tolerance must be greater than round-off, {smallest:.1e}, and finite, not {tolerance!r}.")
    if duration is None and isinstance(control, Prescribed):
        duration = float(control.sizes.sum())
    if not (is_number(duration) and 0 < duration < np.inf):
        raise ValueError(f"duration must be a time greater than zero, not {duration!r}.")
    inside = np.zeros(0) if isinstance(control, Prescribed) else load_times(float(duration))
    if times is not None:
        numbers = real_numbers("times", times).ravel()
        if not np.all((numbers > 0) & (numbers <= duration)):
            raise ValueError(f"times must lie between zero and the duration, {duration:g} s, not {times!r}.")
        inside = np.union1d(inside, numbers)
    first = checked_step_size(FIRST_STEP * duration if dt is None else dt)
    most = MOST_STEPS if steps is None else positive_integer("steps", steps)
    return Control(chosen, control, values, first, np.union1d(inside, [duration]), most)
