"""``study.run``: one scheme on one problem, or an ensemble of such runs, as a labelled dataset."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr

from study.control.controllers import Controller
from study.control.estimators import Estimator
from study.marching.adaptive_run import Adaptive
from study.marching.arguments import (
    checked_bound,
    checked_observers,
    checked_start,
    checked_step_size,
    checked_steps,
    number_of_lanes,
    positive_integer,
    resolve,
)
from study.marching.control import checked_control
from study.marching.equal_run import EqualSteps
from study.marching.failure import ON_FAILURE, SILENT
from study.marching.family import checked_family, checked_lanes, times_of_lanes
from study.marching.parts import Parts
from study.marching.shapes import CountPerRunLike, DisplacementsLike, PerRunLike
from study.mechanics.definition import Problem
from study.mechanics.loads import times_of_problem
from study.observer.base import Observer
from study.observer.energy import ChangeOfEnergy
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.named import schemes


def _check_fit(problem: Problem, scheme: Scheme, observers: tuple[Observer, ...]) -> None:
    """Refuse a scheme that cannot step the problem, or an observer that cannot observe it."""
    for reason in (scheme.refusal(problem), *(observer.refusal(problem) for observer in observers)):
        if reason:
            raise ValueError(reason)


def run(
    problem: str | Problem | Callable[..., Problem],
    scheme: str | Scheme,
    *,
    dt: PerRunLike | None = None,
    steps: CountPerRunLike | None = None,
    tolerance: PerRunLike | None = None,
    duration: float | None = None,
    estimator: str | Estimator | None = None,
    controller: str | Controller | None = None,
    times: DisplacementsLike | None = None,
    observe: str | Observer | Sequence[str | Observer] = ("trajectory",),
    u0: DisplacementsLike | None = None,
    v0: DisplacementsLike | None = None,
    over: Mapping[str, Any] | None = None,
    every: int = 1,
    samples: int | None = None,
    bound: float | None = None,
    on_failure: str = "warn",
    save: str | Path | Parts | None = None,
) -> xr.Dataset:
    r"""March one scheme on one problem and return the observed values, with equal steps or with a tolerance.

    The functions of the problem may read other values, such as globals. The values that hold when the run is called are
    used.

    A run with equal steps whose Newton iteration fails is marched once more with a safeguard: with one unknown a
    bracket, which finds a root wherever the residual changes its sign, and with several unknowns shorter corrections
    (:mod:`study.mechanics.balance`). ``newton_restarts`` counts the iterations that needed the safeguard.

    A run with equal steps that completes although its step exceeds the stability limit of the scheme may be wrong by
    any factor, because a force that is bounded, such as one that yields, also bounds the growth. One ``RuntimeWarning``
    then states ωΔt, the limit and the step that would hold. It considers small motions about the start
    (:mod:`study.marching.stability`). A frequency that grows later, as in a hardening spring, is not considered.

    If the energy must be constant, because the problem has one unknown or a potential and neither damping nor load, a
    run with a tolerance gives a ``RuntimeWarning`` if the energies at its start and end differ by more than a tenth of
    the largest kinetic energy. With a loose tolerance, a scheme can lose that much in a stiff contact.

    Parameters
    ----------
    problem, scheme
        Names in ``study.problems`` and ``study.schemes``, or your own :class:`study.Problem` and
        :class:`study.Scheme`.
    dt
        Step size Δt; an array (lanes,) makes an ensemble. With a tolerance, ``dt`` is the size of the first step, by
        default a thousandth of the duration.
    steps
        Number of steps; an array (lanes,) makes an ensemble, which cannot record along time. With a tolerance,
        ``steps`` is the largest number of steps, by default a million.
    tolerance
        Allowed estimate of the error of a step, in the units of the estimator; an array (lanes,) makes an ensemble.
        The steps are then chosen by estimator and controller.
    duration
        Time at which a run with a tolerance ends. With the controller ``Prescribed``, which needs no tolerance, the
        default is the sum of its step sizes.
    estimator, controller
        Names in ``study.estimators`` and ``study.controllers``, or your own. The default estimator is the first of
        ``embedded_pair``, ``zienkiewicz_xie`` (if the scheme has an ``acceleration_offset``) and ``step_doubling`` that
        fits the scheme and the problem. For a scheme whose formula does not evaluate the force at the end of a step
        (``force_at_end``), and for a force whose slope may jump, as in contact, every estimate also contains the force
        there, except with ``Prescribed``. The default
        controller is ``pi``. ``Prescribed`` by default has no estimator.
    times
        Times at which a step of a run with a tolerance must end, in addition to those of the load. These are the
        ``kinks`` of the load, such as the samples of a ground motion. If a load declares none, they follow from a scan
        of the load: its jumps, its kinks, and the start, peak and end of short pulses. A pulse that lasts at least a
        4,000th of the duration is certain to be found, for up to 4,000 unknowns. Shorter pulses are found if one of
        their times is a number in the load, such as 3.3 in ``t > 3.3`` or a time of a table; declare the ``kinks`` of
        others. At a jump, steps end on either side. ``Prescribed`` uses ``times`` alone.
    observe
        Names in ``study.observers``, or your own :class:`study.Reduction` and :class:`study.Record`.
    u0, v0
        Initial displacement and velocity, in place of the problem's; an array (lanes, ...) makes an ensemble.
    over
        Mapping that makes an ensemble of problems. ``problem`` is then a function that makes a problem, and ``over``
        maps its arguments to arrays (lanes, ...). The function is part of the compiled program: it must use
        ``jax.numpy``, and all lanes have the same shapes.
    every
        Steps between two samples of a record; it must divide ``steps`` unless ``samples`` is given.
    samples
        Number of samples to store after the first; samples after the end of the run are NaN. By default the last sample
        is at the end of the run.
    bound
        Largest displacement of any unknown; a run with a larger displacement ends as unbounded. The default is the
        larger of :math:`10^9 (|u_0| + T |\dot u_0|)` and :math:`10^5\,T^2 f/m` with the duration T, the largest load f
        and the smallest mass m, or infinite if both are zero. With ``np.inf`` there is no bound.
    on_failure
        Reaction to a failed run: ``"warn"``, with scheme, step, time and likely cause, ``"raise"`` or ``"ignore"``. The
        warning of a run that completes beyond the stability limit does not depend on it.
    save
        Folder in which an ensemble is written part by part, one file each, or :class:`study.Parts`. A part that has its
        file is not run again, so the same call continues a run that was killed. The dataset that is returned reads a
        value from its file when the value is used. Needs equal steps.

    Returns
    -------
    xarray.Dataset
        The observed variables, ``status`` (completed, no solution found, not finite, unbounded), ``failed_at_step`` and
        ``newton_restarts``. Records lie along ``t``, the elapsed time, and the runs of an ensemble along ``lane``.
        ``dt``, ``steps``, ``u0`` and ``v0`` are coordinates if they are given per lane, otherwise attributes. ``u0``
        and ``v0`` of more than a thousand unknowns are not attributes. If lanes have their own step sizes, records lie
        along ``sample``, and ``t`` is a coordinate over (lane, sample). Values of a failed run are NaN, and so are its
        samples from the failure on. Further attributes name the problem, the scheme, its parameters and the version.

        A run with a tolerance has no ``newton_restarts``, ``dt``, ``u0`` and ``v0``. It has ``steps``,
        ``failed_at_time``, ``steps_rejected_by_estimate`` and ``steps_rejected_by_solver``, which counts trial steps
        without balance or finite state. Along time it has ``step_size``, ``estimate`` and the numbers of trial steps
        rejected before each step, except in an ensemble without records. The samples before a failure are kept. The
        ``status`` may also be "step too small" or "too many steps". Attributes name estimator, controller, duration and
        tolerance.

    Raises
    ------
    KeyError
        If there is no such problem, scheme, observer, estimator or controller.
    TypeError, ValueError
        If an argument has the wrong type or shape or is out of range, if scheme or observer do not fit the problem, if
        two observers have a variable of the same name, if the records exceed the memory, or if a scheme needs equal
        steps and a tolerance is given.
    RuntimeError
        If a run fails and ``on_failure`` is ``"raise"``.

    Examples
    --------
    >>> import study
    >>> run = dict(dt=0.15 / 20, steps=2000, observe=["max_energy_error"])
    >>> ds = study.run("hardening", "average_acceleration", **run)
    >>> print(f"{ds.max_energy_error.item():.1%}")
    4.1%
    """
    _check_not_traced((problem, dt, u0, v0, over))
    method = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    chosen = checked_observers(observe)
    controlled = tolerance is not None or controller is not None
    _check_on_failure(on_failure)
    if not controlled and (dt is None or steps is None):
        raise TypeError("study.run needs dt and steps, or a tolerance and a duration.")
    if not controlled and any(option is not None for option in (duration, estimator, times)):
        raise TypeError("duration, estimator and times belong to a run with a tolerance.")
    if controlled and save is not None:
        raise TypeError("save belongs to an ensemble with equal steps; write one with a tolerance by its to_netcdf.")
    if controlled and (every != 1 or samples is not None):
        raise TypeError("every and samples belong to a run with equal steps; a run with a tolerance stores every step.")
    values: dict[str, np.ndarray] = {}
    if over is None:
        equations = [resolve(problem, problems, Problem)]  # type: ignore[arg-type, misc]
    else:
        values = checked_family(problem, over, chosen)
        if u0 is not None or v0 is not None:
            raise ValueError(
                "u0 and v0 come from the function that makes the problem; set them there if over is given."
            )
        equations = checked_lanes(problem, values)  # type: ignore[arg-type]
    equation = equations[0]
    start, velocity = checked_start(equation, "u0", u0), checked_start(equation, "v0", v0)
    _check_fit(equation, method, chosen)
    make: Any = None if over is None else problem
    starts = start, velocity
    if controlled:
        load_times = partial(times_of_problem, equation, sides=True)
        if over is not None:
            load_times = partial(times_of_lanes, problem, values, equations)  # type: ignore[arg-type]
        control = checked_control(
            equation, method, chosen, estimator, controller, tolerance, duration, times, dt, steps, load_times
        )
        limit = checked_bound(bound, equations, start, velocity, float(control.times[-1]))
        lanes = number_of_lanes(equation, start, velocity, {"tolerance": control.tolerance, "dt": control.dt}, values)
        silent = on_failure == SILENT
        watches_energy = not (silent or control.controller.sizes_are_given or ChangeOfEnergy().refusal(equation))
        adaptive = Adaptive(equation, method, chosen, starts, make, values, lanes, limit, watches_energy)  # type: ignore[arg-type]
        return adaptive.dataset(control, "ignore" if silent else on_failure)
    step_size, count, every = checked_step_size(dt), checked_steps(steps), positive_integer("every", every)
    lanes = number_of_lanes(equation, start, velocity, {"dt": step_size, "steps": count}, values)
    limit = checked_bound(bound, equations, start, velocity, float(np.max(step_size * count)))
    equal = EqualSteps(
        equation, method, chosen, starts, step_size, count, every, samples, make, values, lanes, limit, on_failure
    )
    return equal.dataset() if save is None else equal.written(save)


def _check_not_traced(arguments: Any) -> None:
    """Refuse a call within ``jit``, which traces all arrays, or ``grad`` or ``vmap``, which trace some of them."""
    leaves = [jnp.zeros(()), *jax.tree.leaves(arguments)]
    for leaf in leaves.copy():
        leaves += [cell.cell_contents for cell in getattr(leaf, "__closure__", None) or ()]
    if any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
        raise TypeError("study.run needs numbers, not values traced by jit, grad or vmap: use study.final_state there.")


def _check_on_failure(on_failure: str) -> None:
    if on_failure not in (*ON_FAILURE, SILENT):
        raise ValueError(f"on_failure must be one of {', '.join(map(repr, ON_FAILURE))}, not {on_failure!r}.")


#: ``run`` for maps and searches, whose runs may fail, or exceed the stability limit, on purpose; neither is reported.
sweep = partial(run, on_failure=SILENT)
