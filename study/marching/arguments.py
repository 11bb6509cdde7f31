"""The arguments of a run, checked before its first step."""

from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.observer.base import Observer
from study.observer.named import observers
from study.problem.definition import Problem
from study.registry import Registry, did_you_mean
from study.scheme.base import Scheme

T = TypeVar("T")

#: Times of a run at which the load is looked at before it starts: at most, at least, and numbers in all.
MOST_LOOKS, FEWEST_LOOKS, LOOKED_AT = 1001, 65, 10_000_000


def resolve(thing: str | T, registry: Registry[T], kind: type[T]) -> T:
    if isinstance(thing, str):
        return registry[thing]
    if not isinstance(thing, kind):
        raise TypeError(f"{thing!r} is no {registry.kind}: give a name or a {kind.__module__}.{kind.__name__}.")
    return thing


def _most_steps() -> int:
    """What a step counter holds twice, in double or in single precision."""
    return jnp.iinfo(jnp.result_type(int)).max // 2


def positive_integer(name, value):
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ValueError(f"{name} must be a whole number of at least 1, not {value!r}.")
    if value > _most_steps():
        raise ValueError(f"{name} must be a whole number of at least 1 and at most {_most_steps()}, not {value!r}.")
    return int(value)


def checked_steps(steps):
    if np.ndim(steps) == 0:
        return np.asarray(positive_integer("steps", steps))
    counts = np.asarray(steps)
    if counts.ndim > 1 or not counts.size:
        raise ValueError(f"steps must be a whole number or one per lane (lanes,), not of shape {counts.shape}.")
    if counts.dtype.kind not in "iu" or counts.min() < 1:
        raise ValueError(f"steps must be whole numbers of at least 1, not {counts}.")
    if counts.max() > _most_steps():
        raise ValueError(f"steps must be whole numbers of at most {_most_steps()}, not {counts}.")
    return counts.astype(int)


def _numbers(name, value):
    try:
        numbers = np.asarray(value, dtype=np.float64)
        if np.asarray(value).dtype.kind == "b":
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number or an array of numbers, not {value!r}.") from None
    if numbers.size == 0:
        raise ValueError(f"{name} is empty; an ensemble needs at least one lane.")
    return numbers


def checked_step_size(dt):
    dt = _numbers("dt", dt)
    if dt.ndim > 1:
        raise ValueError(f"dt must be a number or one per lane (lanes,), not an array of shape {dt.shape}.")
    if not np.all(np.isfinite(dt) & (dt > 0)):
        raise ValueError(f"dt must be finite and greater than zero, not {dt[()]}.")
    return dt


def checked_start(problem, u0):
    shape = np.shape(problem.u0)
    if u0 is None:
        return np.asarray(problem.u0)
    u0 = _numbers("u0", u0)
    if (u0.shape != shape and u0.shape[1:] != shape) or u0.ndim > len(shape) + 1:
        ensemble = f"({', '.join(['lanes', *map(str, shape)])})"
        raise ValueError(
            f"u0 must have the shape {shape} of the problem, or {ensemble} for an ensemble, not {u0.shape}."
        )
    if not np.isfinite(u0).all():
        raise ValueError(f"u0 must be finite, not {u0}.")
    return u0


def checked_observers(problem, observe) -> tuple[Observer, ...]:
    if observe is None:
        raise TypeError(f"observe must be a list of observers; {did_you_mean('', observers)}")
    chosen = [resolve(o, observers, Observer) for o in ([observe] if isinstance(observe, str) else observe)]
    for observer in chosen:
        if argument := observer.lacking(problem):
            raise ValueError(
                f"{', '.join(observer.variables)} of '{problem.title}' needs Problem({argument}=...), "
                "which it was made without."
            )
    return tuple(chosen)


def check_fit(problem: Problem, scheme: Scheme, duration: float) -> None:
    """Refuse a problem that the scheme cannot step, and a load that is not finite at some time of the run."""
    if reason := scheme.refusal(problem):
        raise ValueError(reason)
    if problem.load is not None:
        looks = int(np.clip(LOOKED_AT // np.size(problem.u0), FEWEST_LOOKS, MOST_LOOKS))
        times = np.linspace(0.0, duration, looks)
        finite = np.asarray(_are_finite(problem.load, times))
        if not finite.all():
            raise ValueError(f"the load of '{problem.title}' is not finite at t = {times[np.argmin(finite)]:g}.")


@eqx.filter_jit
def _are_finite(load, times):
    return jax.lax.map(lambda t: jnp.isfinite(load(t)).all(), times)


def number_of_lanes(problem: Problem, u0: np.ndarray, **of_lanes: np.ndarray) -> int:
    """How many lanes an ensemble has, 0 where it is a single run."""
    lengths = {name: len(value) for name, value in of_lanes.items() if value.ndim}
    lengths |= {"u0": len(u0)} if u0.ndim > np.ndim(problem.u0) else {}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"what differs from lane to lane must have one length to make an ensemble, not {told}.")
    return max(lengths.values(), default=0)
