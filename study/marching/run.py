"""``study.run``: one scheme on one problem, or an ensemble of such runs, as a labelled dataset."""

import math
from collections.abc import Sequence

import equinox as eqx
import jax
import numpy as np
import xarray as xr
from tqdm import tqdm

from study.marching.arguments import (
    check_fit,
    check_memory,
    checked_observers,
    checked_start,
    checked_step_size,
    checked_steps,
    number_of_lanes,
    positive_integer,
    resolve,
)
from study.marching.ensemble import march_ensemble
from study.marching.march import March, march
from study.marching.result import Result, labelled
from study.marching.shapes import Counts, CountsLike, Displacements, DisplacementsLike, Numbers, NumbersLike
from study.observer.base import Observer, Record, Reduction
from study.problem.definition import Problem
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.linearised import Linearised
from study.scheme.named import schemes

#: Steps between two chances to interrupt a single run: about a second.
PAUSE = 2**24

#: Samples × lanes × unknowns whose records fit into the memory of any machine.
FEW = 10_000_000


def _march_alone(definition: March, u0: Displacements, dt: Numbers, steps: int, every: int, samples: int) -> Result:
    """March a single run; a long one pauses now and then, and shows a progress bar in a terminal."""
    pauses = range(PAUSE, steps + PAUSE, PAUSE)
    progress = None
    # a loop of its own for every=1 is worth compiling only for one unknown, whose steps are short
    each_step = every == 1 and not u0.ndim
    for pause in tqdm(pauses, disable=True if len(pauses) < 2 else None, leave=False):
        until = np.asarray(min(pause, steps))
        progress, result = march(definition, u0, dt, until, np.asarray(every), samples, each_step, progress=progress)
        if result.status:  # waits for the result, so that Ctrl-C is heard between two pauses
            break
    return jax.tree.map(np.asarray, result)


def _samples(records: Sequence[Record], steps: Counts, every: int, samples: int | None) -> int:
    """Number of samples to store after the first."""
    if records and steps.ndim:
        raise ValueError(
            f"'{next(iter(records[0].variables))}' is recorded along time, which takes one number of steps for all "
            "lanes; give steps as a number, or observe what has one value a run."
        )
    if samples is None and np.any(steps % every):
        raise ValueError(f"every must divide the number of steps; {every} does not divide {steps[()]}.")
    if not records:
        return 0
    return int(steps) // every if samples is None else positive_integer("samples", samples)


def _check_memory(definition: March, u0: Displacements, dt: Numbers, samples: int) -> None:
    """Refuse records that exceed the memory; their shapes are those of the first sample, which is not computed."""
    if (samples + 1) * u0.size <= FEW:
        return
    progress, _ = eqx.filter_eval_shape(definition.start, u0, dt, 0)
    first = progress.stored.items()
    check_memory({name: math.prod(one.shape) * one.dtype.itemsize for name, one in first}, samples + 1)


def run(
    problem: str | Problem,
    scheme: str | Scheme,
    *,
    dt: NumbersLike,
    steps: CountsLike,
    observe: str | Observer | Sequence[str | Observer] = ("trajectory",),
    u0: DisplacementsLike | None = None,
    every: int = 1,
    samples: int | None = None,
) -> xr.Dataset:
    """March one scheme on one problem and return what was observed.

    Parameters
    ----------
    problem, scheme
        Names in ``study.problems`` and ``study.schemes``, or your own :class:`study.Problem` and
        :class:`study.Scheme`.
    dt
        Step size Δt; an array (lanes,) makes an ensemble.
    steps
        Number of steps; an array (lanes,) makes an ensemble, which cannot record along time.
    observe
        Names in ``study.observers``, or your own :class:`study.Reduction` and :class:`study.Record`.
    u0
        Initial displacement, in place of the problem's; an array (lanes, ...) makes an ensemble.
    every
        Steps between two samples of a record; it must divide ``steps`` unless ``samples`` is given.
    samples
        Number of samples to store after the first; those after the end of the run are NaN. Every new number compiles
        anew, whereas a new number of steps does not: give it if you run many lengths.

    Returns
    -------
    xarray.Dataset
        The observed variables, ``status`` and ``failed_at_step``. Records lie along ``t``, the elapsed time; the runs
        of an ensemble along ``lane``. If lanes have their own step sizes, records lie along ``sample`` and ``t`` is a
        coordinate over (lane, sample). Values of a failed run are NaN, and its samples from the failure on.

    Raises
    ------
    KeyError
        If there is no such problem, scheme or observer.
    TypeError, ValueError
        If an argument has the wrong type or shape or is out of range, if scheme or observer do not fit the problem, or
        if the records exceed the memory.

    Examples
    --------
    >>> import study
    >>> ds = study.run("hardening", "average_acceleration", dt=0.15 / 20, steps=2000, observe=["max_energy_error"])
    >>> print(f"{ds.max_energy_error.item():.1f} {ds.max_energy_error.units}")
    4.1 percent
    """
    equation = resolve(problem, problems, Problem)
    method = resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    step_size, start = checked_step_size(dt), checked_start(equation, u0)
    count, every = checked_steps(steps), positive_integer("every", every)
    chosen = checked_observers(equation, observe)
    reductions = tuple(o for o in chosen if isinstance(o, Reduction))
    records = tuple(o for o in chosen if isinstance(o, Record))
    room = _samples(records, count, every, samples)
    lanes = number_of_lanes(equation, start, step_size, count)
    marched = Linearised(method) if any(o.needs_neighbour for o in chosen) else method
    definition = March(equation, marched, reductions, records, bool(lanes))
    if lanes:
        start = np.broadcast_to(start, (lanes, *np.shape(equation.u0)))
    dts = np.broadcast_to(step_size, lanes) if lanes else step_size
    _check_memory(definition, start, dts, room)
    check_fit(equation, method, float(np.max(step_size * count)))
    if lanes:
        result = march_ensemble(definition, start, dts, count, every, room)
    else:
        result = _march_alone(definition, start, dts, int(count), every, room)
    return labelled(result, equation, method, chosen, step_size, count, every, room, bool(lanes))
