"""Checks of the arguments of a run, before its first step.

Most functions return an argument in the form that the march takes. If the argument is invalid, they raise an error. Its
message is one sentence that names the argument, the expected value and the received value.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import real_numbers
from study.algebra.jit import jit
from study.algebra.matrices import diagonal
from study.algebra.scalars import check_unmasked, is_number, is_whole
from study.marching.shapes import CountPerRun, CountPerRunLike, Displacements, DisplacementsLike, PerRun, PerRunLike
from study.mechanics.definition import Problem
from study.mechanics.loads import times_of
from study.observer.base import Observer
from study.observer.named import observers
from study.registry import Registry, did_you_mean

T = TypeVar("T")

#: Names of variables and coordinates of a result, which no variable of an observer may have.
RESERVED = (
    "status",
    "failed_at_step",
    "newton_restarts",
    "t",
    "lane",
    "sample",
    "component",
    "dt",
    "steps",
    "u0",
    "v0",
)

#: Default bound of the displacement, as multiples of u₀ + T u̇₀ and of T² f/m, with the duration T, the largest load f
#: and the smallest mass m. It is large, because a physically unstable motion may grow from a tiny displacement.
START_MULTIPLES, LOAD_MULTIPLES = 1e9, 1e5

#: Largest number of times of jumps, kinks and short pulses of the load at which its size is taken before a run.
PULSES = 256

#: Sampling of the load before a run: maximum and minimum number of samples, and cap on samples × unknowns.
MOST_SAMPLES, FEWEST_SAMPLES, SAMPLED = 1001, 65, 10_000_000


def resolve(thing: str | T, registry: Registry[T], kind: type[T]) -> T:
    """Entry of the registry if ``thing`` is a name, or ``thing`` itself if it is an instance of ``kind``.

    A problem is returned with what follows from its functions as they are now.
    """
    if isinstance(thing, str):
        return registry[thing]
    if not isinstance(thing, kind):
        raise TypeError(f"{thing!r} is no {registry.kind}: give a name or a study.{kind.__name__}.")
    return thing.current() if isinstance(thing, Problem) else thing  # type: ignore[return-value]


def _most_steps() -> int:
    """Maximum number of steps: a quarter of the largest integer, because a march multiplies step numbers by three."""
    return jnp.iinfo(jnp.result_type(int)).max // 4


def positive_integer(name: str, value: Any) -> int:
    """``value`` as an ``int``, if it is a whole number between 1 and the maximum number of steps."""
    if not is_whole(value, 1):
        raise ValueError(f"{name} must be a whole number of at least 1, not {value!r}.")
    if value > _most_steps():
        raise ValueError(f"{name} must be a whole number of at least 1 and at most {_most_steps()}, not {value!r}.")
    return int(value)


def checked_steps(steps: CountPerRunLike) -> CountPerRun:
    """Number of steps, of shape () or (lanes,)."""
    if np.ndim(steps) == 0:
        return np.asarray(positive_integer("steps", steps))
    check_unmasked("steps", steps)
    counts = np.asarray(steps)
    if counts.ndim > 1 or not counts.size:
        raise ValueError(f"steps must be a whole number or of shape (lanes,), not of shape {counts.shape}.")
    if counts.dtype.kind not in "iu" or counts.min() < 1:
        raise ValueError(f"steps must be whole numbers of at least 1, not {counts}.")
    if counts.max() > _most_steps():
        raise ValueError(f"steps must be whole numbers of at most {_most_steps()}, not {counts}.")
    return counts.astype(int)


def _numbers(name: str, value: Any) -> np.ndarray:
    numbers = real_numbers(name, value)
    if numbers.size == 0:
        raise ValueError(f"{name} is empty; an ensemble needs at least one lane.")
    return numbers


def checked_step_size(dt: PerRunLike) -> PerRun:
    """Step size, of shape () or (lanes,)."""
    dt = _numbers("dt", dt)
    if dt.ndim > 1:
        raise ValueError(f"dt must be a number or an array of shape (lanes,), not an array of shape {dt.shape}.")
    if not np.all(np.isfinite(dt) & (dt > 0)):
        raise ValueError(f"dt must be finite and greater than zero, not {dt[()]}.")
    return dt


def checked_start(problem: Problem, name: str, start: DisplacementsLike | None) -> Displacements:
    """``u0`` or ``v0``, of the problem's shape or with an axis of lanes in front; None stands for the problem's own."""
    shape = np.shape(problem.u0)
    if start is None:
        return np.asarray(getattr(problem, name))
    start = _numbers(name, start)
    if (start.shape != shape and start.shape[1:] != shape) or start.ndim > len(shape) + 1:
        ensemble = f"({', '.join(['lanes', *map(str, shape)])})"
        raise ValueError(
            f"{name} must have the shape {shape} of the problem, or {ensemble} for an ensemble, not {start.shape}."
        )
    if not np.isfinite(start).all():
        raise ValueError(f"{name} must be finite, not {start}.")
    return start


def checked_observers(observe: str | Observer | Sequence[str | Observer]) -> tuple[Observer, ...]:
    """Observers, given by name or as objects; a single observer need not be in a list."""
    if observe is None:
        raise TypeError(f"observe must be a list of observers; {did_you_mean('', observers)}")
    listed = [observe] if isinstance(observe, str | Observer | type) else observe
    chosen = tuple(resolve(o, observers, Observer) for o in listed)  # type: ignore[type-abstract]
    for observer in chosen:
        if not hasattr(observer, "variables"):
            raise TypeError(
                f"{type(observer).__name__} lacks the class variable 'variables': long_name and units of each variable "
                "that it returns, by name."
            )
    names = [*RESERVED, *(name for observer in chosen for name in observer.variables)]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(
                f"two variables of the result would have the name '{name}'; give one of them another name."
            )
    return chosen


def checked_bound(
    bound: float | None, problems: Sequence[Problem], u0: Displacements, v0: Displacements, duration: float
) -> float:
    """Bound of the displacement of a run: as given, or a large multiple of the motion that start and load cause.

    The default bound is infinite if neither start nor load causes a motion.

    Raises
    ------
    ValueError
        If ``bound`` is not a positive number, or if it is None and a sample of the load is not finite.
    """
    if bound is not None:
        if not (is_number(bound) and bound > 0):
            raise ValueError(f"bound must be a displacement greater than zero, np.inf for none, not {bound!r}.")
        return float(bound)
    starts = [(u0, v0), *((problem.u0, problem.v0) for problem in problems[1:])]
    farthest = START_MULTIPLES * max(np.abs(u).max() + duration * np.abs(v).max() for u, v in starts)
    for problem in problems:
        if problem.load is not None:
            masses = np.asarray(diagonal(1.0 if problem.mass is None else problem.mass))
            reached = LOAD_MULTIPLES * duration**2 * _largest_load(problem, duration) / masses[masses > 0].min()
            farthest = max(farthest, reached)
    return float(farthest) or np.inf


def _largest_load(problem: Problem, duration: float) -> float:
    count = int(np.clip(SAMPLED // np.size(problem.u0), FEWEST_SAMPLES, MOST_SAMPLES))
    # a pulse may lie between the samples; the number of times is the same for all loads, which share a program
    pulses = times_of(problem.load, duration, sides=True)[:PULSES]
    times = np.concatenate([np.linspace(0.0, duration, count), pulses, np.zeros(PULSES - len(pulses))])
    sizes = np.asarray(_sizes(problem.load, times))
    if not np.isfinite(sizes).all():
        raise ValueError(
            f"the load of '{problem.title}' is not finite at t = {times[np.argmin(np.isfinite(sizes))]:g}."
        )
    return sizes.max()


@partial(jit, compiler=eqx.filter_jit)
def _sizes(load, times):
    return jax.lax.map(lambda t: jnp.abs(load(t)).max(), times)


def number_of_lanes(
    problem: Problem, u0: Displacements, v0: Displacements, arguments: Mapping[str, np.ndarray], over: Mapping
) -> int:
    """Number of lanes of an ensemble, 0 for a single run; an argument in ``own`` has the shape () or (lanes,)."""
    lengths = {name: len(value) for name, value in arguments.items() if value.ndim}
    lengths |= {name: len(value) for name, value in (("u0", u0), ("v0", v0)) if value.ndim > np.ndim(problem.u0)}
    lengths |= {f"over['{name}']": len(value) for name, value in over.items()}
    if len(set(lengths.values())) > 1:
        received = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"the lanes of an ensemble need arrays of one length, not {received}.")
    return max(lengths.values(), default=0)


def check_memory(records: Mapping[str, int], samples: int) -> None:
    """Refuse records if twice their size exceeds the free memory of this machine.

    Parameters
    ----------
    records
        Number of bytes of one sample of all lanes, by variable.
    samples
        Number of samples.
    """
    import psutil  # imported here, because few runs need it

    memory, needed = psutil.virtual_memory().available, 2 * samples * sum(records.values())
    if needed > memory:
        raise ValueError(
            f"{samples} samples of {', '.join(map(repr, records))} need {needed / 2**30:.0f} GiB, and this machine has "
            f"{memory / 2**30:.0f} GiB of free memory: store fewer samples with every=, or observe single values."
        )
