"""``study.run``: one scheme on one problem, or an ensemble of them, as a labelled dataset."""

from collections.abc import Sequence

import jax
import numpy as np
import xarray as xr
from tqdm import tqdm

from study.marching.arguments import (
    check_fit,
    checked_observers,
    checked_start,
    checked_step_size,
    checked_steps,
    number_of_lanes,
    positive_integer,
    resolve,
)
from study.marching.ensemble import march_ensemble
from study.marching.march import COMPLETED, STATUS_MEANINGS, March, Outcome, march
from study.observer.base import Observer, Record, Reduction
from study.problem.definition import Problem
from study.problem.named import problems
from study.scheme.base import Scheme
from study.scheme.linearised import Linearised
from study.scheme.named import schemes

#: Steps between two chances to interrupt a single run: about a second.
PAUSE = 2**24

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
    definition, method = resolve(problem, problems, Problem), resolve(scheme, schemes, Scheme)  # type: ignore[type-abstract]
    step_size, start = checked_step_size(dt), checked_start(definition, u0)
    count, every = checked_steps(steps), positive_integer("every", every)
    chosen = checked_observers(definition, observe)
    check_fit(definition, method, float(np.max(step_size * count)))
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
        room = positive_integer("samples", samples)
    lanes = number_of_lanes(definition, start, dt=step_size, steps=count)
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
