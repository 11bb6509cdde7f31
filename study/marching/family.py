"""An ensemble of problems: each lane has its own arguments of the function that makes the problem."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.scalars import check_unmasked
from study.marching.arguments import RESERVED
from study.mechanics.definition import Problem
from study.mechanics.loads import times_of
from study.mechanics.scan import Times, beside_jumps, events
from study.observer.base import Observer


def checked_family(make: Any, over: Mapping[str, Any], observers: Sequence[Observer]) -> dict[str, np.ndarray]:
    """The arrays of ``over`` after their check, each of shape (lanes, ...).

    Raises
    ------
    TypeError, ValueError
        If ``make`` is not a function of the names in ``over``, if the result already has one of these names, or if the
        arrays are not numbers of one length.
    """
    if not callable(make) or isinstance(make, Problem):
        description = f"the problem '{make.title}'" if isinstance(make, Problem) else repr(make)
        raise TypeError(f"over= needs a function that makes a problem in place of {description}.")
    if not isinstance(over, Mapping):
        raise TypeError(f"over must be a mapping of names to arrays, such as over={{'scale': [1, 2]}}, not {over!r}.")
    arguments = inspect.signature(make).parameters
    takes_any = any(p.kind is p.VAR_KEYWORD for p in arguments.values())
    reserved = {*RESERVED, *(name for observer in observers for name in observer.variables)}
    values = {name: _array(name, value) for name, value in over.items()}
    for name, value in values.items():
        if name not in arguments and not takes_any:
            raise ValueError(f"over has '{name}', which the function that makes the problem does not take.")
        if name in reserved:
            raise ValueError(f"over has '{name}', a name that the result has already; rename the argument.")
        if value.dtype.kind not in "fiu" or value.ndim == 0 or not np.isfinite(value).all():
            raise ValueError(f"over['{name}'] must be an array of finite numbers (lanes, ...), not {over[name]!r}.")
    lengths = {name: len(value) for name, value in values.items()}
    if len(set(lengths.values())) != 1 or not all(lengths.values()):
        raise ValueError(f"over needs arrays of one length, at least one, not {lengths or 'nothing'}.")
    for name, argument in arguments.items():
        if (
            argument.default is argument.empty
            and argument.kind in (argument.POSITIONAL_OR_KEYWORD, argument.KEYWORD_ONLY)
            and name not in over
        ):
            raise ValueError(f"over lacks '{name}', an argument of the function that makes the problem.")
    return {name: value.astype(float) for name, value in values.items()}


def _array(name: str, value: Any) -> np.ndarray:
    check_unmasked(f"over['{name}']", value)
    try:
        return np.asarray(value)
    except ValueError:
        raise ValueError(
            f"over['{name}'] has rows of different lengths: pad the shorter ones, ground motions by "
            "study.GroundMotion.padded."
        ) from None


def checked_lanes(make: Callable[..., Problem], over: Mapping[str, np.ndarray]) -> list[Problem]:
    """The problems of the first lane and of the lanes where an argument is least or largest.

    Only the problems of these lanes are made with numbers, which the checks of a problem can examine.

    Raises
    ------
    TypeError, ValueError
        If ``make`` does not return a problem, if the checks of a problem refuse it, or if an unknown has no mass.
    """
    ends = {0}
    for value in over.values():
        flat = value.reshape(len(value), -1)
        ends |= {*flat.argmin(axis=0).tolist(), *flat.argmax(axis=0).tolist()}
    # arrays of JAX, as in the march: the product of a NumPy number and a sparse matrix of JAX is not a sparse matrix
    problems = {lane: make(**{name: jnp.asarray(value[lane]) for name, value in over.items()}) for lane in sorted(ends)}
    for lane, problem in problems.items():
        if not isinstance(problem, Problem):
            raise TypeError(f"the function given with over= must return a study.Problem, not {problem!r}.")
        if problem.massless:
            raise ValueError(
                f"lane {lane} of over has an unknown without mass, which a family of problems cannot have."
            )
    return list(problems.values())


def times_of_lanes(
    make: Callable[..., Problem], over: Mapping[str, np.ndarray], problems: Sequence[Problem], duration: float
) -> Times:
    """Times within ``duration`` at which the steps of all lanes should end, from their loads.

    They are the declared kinks of the loads of ``problems``, which are some lanes, or events of all loads.
    """
    loads = [problem.load for problem in problems if problem.load is not None]
    if not loads:
        return np.zeros(0)
    if any(np.size(getattr(load, "kinks", ())) for load in loads):
        return np.unique(np.concatenate([times_of(load, duration, sides=True) for load in loads]))
    lanes = {name: jnp.asarray(value) for name, value in over.items()}

    def load_of_lanes(t):
        return jax.vmap(lambda values: make(**values).load(t))(lanes)  # type: ignore[misc]

    times = beside_jumps(load_of_lanes, events(load_of_lanes, duration), duration)
    return times[(times > 0) & (times < duration)]
