"""``study.run``: one scheme on one problem, or an ensemble of them, as a labelled dataset."""

from collections.abc import Sequence
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import xarray as xr
from tqdm import tqdm

from study.ensemble import march_ensemble
from study.march import COMPLETED, STATUS_MEANINGS, March, Outcome, march
from study.observers import Observer, Record, Reduction, observers
from study.problem import Problem
from study.problems import problems
from study.registry import Registry, did_you_mean
from study.schemes import Linearised, Scheme, schemes

T = TypeVar("T")

#: Steps between two chances to interrupt a single run: about a second.
PAUSE = 2**24

#: Times of a run at which the load is looked at before it starts: at most, at least, and numbers in all.
MOST_LOOKS, FEWEST_LOOKS, LOOKED_AT = 1001, 65, 10_000_000

STATUS_ATTRIBUTES = {
    "long_name": "how the run ended",
    "flag_values": np.arange(3, dtype=np.int32),
    "flag_meanings": STATUS_MEANINGS,
}
FAILED_AT_STEP_ATTRIBUTES = {"long_name": "step at which the run failed, -1 where it did not", "units": "1"}


def _march_alone(definition: March, u0: np.ndarray, dt: np.ndarray, steps: int, every: int, samples: int) -> Outcome:
    """One run, a long one with a bar of its progress where somebody watches, and a pause now and then."""
    pauses = range(PAUSE, steps + PAUSE, PAUSE)
    progress = None
    # a loop of its own for every step is worth compiling only with one unknown, whose steps are the shorter
    each_step = every == 1 and not u0.ndim
    for pause in tqdm(pauses, disable=True if len(pauses) < 2 else None, leave=False):
        until = np.asarray(min(pause, steps))
        progress, outcome = march(definition, u0, dt, until, np.asarray(every), samples, each_step, progress=progress)
        if outcome.status:  # waits for the result, so that Ctrl-C is heard between two pauses
            break
    return outcome


def _resolve(thing: str | T, registry: Registry[T], kind: type[T]) -> T:
    if isinstance(thing, str):
        return registry[thing]
    if not isinstance(thing, kind):
        raise TypeError(f"{thing!r} is no {registry.kind}: give a name or a {kind.__module__}.{kind.__name__}.")
    return thing


def _most_steps() -> int:
    """What a step counter holds twice, in double or in single precision."""
    return jnp.iinfo(jnp.result_type(int)).max // 2


def _positive_integer(name, value):
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ValueError(f"{name} must be a whole number of at least 1, not {value!r}.")
    if value > _most_steps():
        raise ValueError(f"{name} must be a whole number of at least 1 and at most {_most_steps()}, not {value!r}.")
    return int(value)


def _checked_steps(steps):
    if np.ndim(steps) == 0:
        return np.asarray(_positive_integer("steps", steps))
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


def _checked_step_size(dt):
    dt = _numbers("dt", dt)
    if dt.ndim > 1:
        raise ValueError(f"dt must be a number or one per lane (lanes,), not an array of shape {dt.shape}.")
    if not np.all(np.isfinite(dt) & (dt > 0)):
        raise ValueError(f"dt must be finite and greater than zero, not {dt[()]}.")
    return dt


def _checked_start(problem, u0):
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


def _checked_observers(problem, observe) -> tuple[Observer, ...]:
    if observe is None:
        raise TypeError(f"observe must be a list of observers; {did_you_mean('', observers)}")
    chosen = [_resolve(o, observers, Observer) for o in ([observe] if isinstance(observe, str) else observe)]
    for observer in chosen:
        if argument := observer.lacking(problem):
            raise ValueError(
                f"{', '.join(observer.variables)} of '{problem.title}' needs Problem({argument}=...), "
                "which it was made without."
            )
    return tuple(chosen)


def _check_fit(problem: Problem, scheme: Scheme, duration: float) -> None:
    """Refuse a mass that the scheme cannot take, and a load that is no number at some time of the run."""
    if problem.massless and scheme.needs_mass:
        raise ValueError(
            f"'{scheme.title}' needs a mass at every unknown, and that of '{problem.title}' is singular: take an "
            "implicit scheme that is unconditionally stable, or give every unknown a mass."
        )
    if problem.load is not None:
        looks = int(np.clip(LOOKED_AT // np.size(problem.u0), FEWEST_LOOKS, MOST_LOOKS))
        times = np.linspace(0.0, duration, looks)
        finite = np.asarray(_are_finite(problem.load, times))
        if not finite.all():
            raise ValueError(f"the load of '{problem.title}' is not finite at t = {times[np.argmin(finite)]:g}.")


@eqx.filter_jit
def _are_finite(load, times):
    return jax.lax.map(lambda t: jnp.isfinite(load(t)).all(), times)


def _lanes(problem: Problem, u0: np.ndarray, **of_lanes: np.ndarray) -> int:
    """How many lanes an ensemble has, 0 where it is a single run."""
    lengths = {name: len(value) for name, value in of_lanes.items() if value.ndim}
    lengths |= {"u0": len(u0)} if u0.ndim > np.ndim(problem.u0) else {}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"what differs from lane to lane must have one length to make an ensemble, not {told}.")
    return max(lengths.values(), default=0)


def run(
    problem: str | Problem,
    scheme: str | Scheme,
    *,
    dt: float | np.ndarray,
    steps: int | np.ndarray,
    observe: Sequence[str | Observer] = ("trajectory",),
    u0: float | np.ndarray | None = None,
    every: int = 1,
    samples: int | None = None,
) -> xr.Dataset:
    """March one scheme on one problem and return what was observed.

    Parameters
    ----------
    problem, scheme
        Names out of ``study.problems`` and ``study.schemes``, or objects of your own.
    dt
        Step size; an array (lanes,) makes an ensemble.
    steps
        Number of steps; an array (lanes,) makes an ensemble, in which nothing can be recorded along time.
    observe
        Names out of ``study.observers``, or observers of your own.
    u0
        Initial displacement in place of the problem's; an array (lanes, ...) makes an ensemble.
    every
        Store what is recorded along time at every so many steps; without ``samples`` it must divide ``steps``.
    samples
        How many samples to store behind the first, in place of those of the whole run; NaN where the run has ended.
        Every new number is compiled anew, which a new number of steps alone is not.

    Returns
    -------
    xarray.Dataset
        The observed variables with ``status`` and ``failed_at_step``, along ``t`` (elapsed time) where recorded and
        along ``lane`` in an ensemble. Lanes with step sizes of their own have the dimension ``sample`` and the
        coordinate ``t`` over (lane, sample). Where a run failed there is NaN.

    Raises
    ------
    KeyError
        If there is no such problem, scheme or observer.
    ValueError, TypeError
        If an argument is out of range or has the wrong shape; the message tells which and what would be right.

    Examples
    --------
    >>> import study
    >>> ds = study.run("hardening", "average_acceleration", dt=0.15 / 20, steps=2000, observe=["max_energy_error"])
    >>> print(f"{ds.max_energy_error.item():.1f} {ds.max_energy_error.units}")
    4.1 percent
    """
    definition, method = _resolve(problem, problems, Problem), _resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    step_size, start = _checked_step_size(dt), _checked_start(definition, u0)
    count, every = _checked_steps(steps), _positive_integer("every", every)
    chosen = _checked_observers(definition, observe)
    _check_fit(definition, method, float(np.max(step_size * count)))
    marched = Linearised(method) if any(o.needs_neighbour for o in chosen) else method
    reductions = tuple(o for o in chosen if isinstance(o, Reduction))
    records = tuple(o for o in chosen if isinstance(o, Record))
    if records and count.ndim:
        raise ValueError(
            f"'{next(iter(records[0].variables))}' is recorded along time, which takes one number of steps for all "
            "lanes; give steps as a number, or observe what has one value a run."
        )
    if samples is None and np.any(count % every):
        raise ValueError(f"every must divide the number of steps; {every} does not divide {count[()]}.")
    if not records:
        room = 0
    elif samples is None:
        room = int(count) // every
    else:
        room = _positive_integer("samples", samples)
    lanes = _lanes(definition, start, dt=step_size, steps=count)
    if lanes:
        start = np.broadcast_to(start, (lanes, *np.shape(definition.u0)))
        dts = np.broadcast_to(step_size, lanes)
        outcome = march_ensemble(March(definition, marched, reductions, records, True), start, dts, count, every, room)
    else:
        alone = March(definition, marched, reductions, records)
        outcome = jax.tree.map(np.asarray, _march_alone(alone, start, step_size, int(count), every, room))
    going_on = np.arange(room + 1) * every <= count
    if not np.all(going_on):
        # where the next sample is due stands the end of the run
        along = bool(lanes)
        cut = {
            name: np.where(going_on.reshape((1,) * along + (-1,) + (1,) * (values.ndim - along - 1)), values, np.nan)
            for name, values in outcome.samples.items()
        }
        outcome = outcome._replace(samples=cut)
    return _labelled(definition, method, outcome, chosen, step_size, every, room, bool(lanes))


def _labelled(problem, scheme, outcome, chosen, dt, every, samples, ensemble) -> xr.Dataset:
    attributes = {name: a for observer in chosen for name, a in observer.variables.items()}
    lane = ("lane",) if ensemble else ()
    component = ("component",) if np.ndim(problem.u0) else ()
    along = "sample" if dt.ndim else "t"
    data = {
        "status": (lane, np.asarray(outcome.status, dtype=np.int32), STATUS_ATTRIBUTES),
        "failed_at_step": (lane, np.asarray(outcome.failed_at_step), FAILED_AT_STEP_ATTRIBUTES),
    }
    for name, value in outcome.values.items():
        dims = (*lane, *component[: np.ndim(value) - len(lane)])
        failed = np.reshape(outcome.status != COMPLETED, (-1,) * len(lane) + (1,) * (len(dims) - len(lane)))
        # whole numbers become floats here, where double precision holds them all
        data[name] = (dims, np.where(failed, np.nan, value), attributes[name])
    for name, value in outcome.samples.items():
        extra = component[: np.ndim(value) - len(lane) - 1]
        data[name] = ((*lane, along, *extra), np.asarray(value), attributes[name])
    coordinates = {}
    if samples:
        t = np.multiply.outer(dt, np.arange(samples + 1) * every)
        coordinates["t"] = ((*lane, "sample") if dt.ndim else "t", t, {"long_name": "elapsed time", "units": "s"})
    return xr.Dataset(
        data,
        coordinates,
        {"title": f"{scheme.title} on the {problem.title}", "problem": problem.title, "scheme": scheme.title},
    )
