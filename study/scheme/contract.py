"""Checks of the contract of a scheme: JAX can trace its functions, which return a state with u and v and an effort."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.counting import counting
from study.algebra.scalars import is_number, is_whole
from study.mechanics.function_checks import NOT_TRACEABLE
from study.mechanics.state import Effort


def check_attributes(scheme: Any) -> None:
    """Refuse a scheme whose title, orders or stability limit are invalid.

    Raises
    ------
    TypeError
        If an attribute is invalid; the message names the class.
    """
    class_name = type(scheme).__name__
    if not isinstance(scheme.title, str) or not scheme.title.strip():
        raise TypeError(f"title of {class_name} must be a non-blank string, not {scheme.title!r}.")
    for name in ("order", "order_with_damping"):
        try:
            value = getattr(scheme, name)
        except Exception as error:  # a property of a user's scheme may raise any exception
            raise TypeError(f"{name} of {class_name} raises {type(error).__name__}: {error}") from error
        if not is_whole(value, 1):
            raise TypeError(f"{name} of {class_name} must be a whole number of at least 1, not {value!r}.")
    for name in ("explicit", "keeps_energy"):
        if not isinstance(value := getattr(scheme, name), bool | np.bool_):
            raise TypeError(f"{name} of {class_name} must be True or False, not {value!r}.")
    limit = scheme.stability_limit
    if limit is not None and not (is_number(limit) and limit >= 0):
        raise TypeError(f"stability_limit of {class_name} must be a number of at least 0 or None, not {limit!r}.")


def _returned(scheme: Any, method: str, *arguments: Any) -> tuple[Any, Effort]:
    """Result of a method of a scheme, checked to be a pair of a state and an effort."""
    call = f"{method} of {type(scheme).__name__}"
    try:
        result = getattr(scheme, method)(*arguments)
    except NOT_TRACEABLE as error:
        raise TypeError(
            f"{call} branches on a number that JAX traces, or passes it to NumPy or Python: write it with jax.numpy, "
            "and use jnp.where for a choice."
        ) from error
    except (AttributeError, NameError, RuntimeError) as error:
        raise TypeError(f"{call} raises {type(error).__name__}: {error}") from error
    if not (isinstance(result, tuple) and len(result) == 2 and isinstance(result[1], Effort)):
        raise TypeError(f"{call} must return a state and a study.building.Effort, not {type(result).__name__}.")
    if None in (result[1].iterations, result[1].converged):
        raise TypeError(f"{call} must return a study.building.Effort with iterations and converged, not {result[1]!r}.")
    return result


def _check_motion(call: str, state: Any, u: Any) -> None:
    for name in ("u", "v"):
        if not hasattr(state, name) or jnp.shape(getattr(state, name)) != u.shape:
            raise TypeError(f"{call} must return a state with '{name}' of shape {u.shape}.")
        if (kind := jnp.result_type(getattr(state, name))) != u.dtype:
            raise TypeError(f"{call} must return '{name}' in {u.dtype}, not in {kind}.")


def _counted(scheme: Any, method: str, *arguments: Any) -> tuple[Any, Effort]:
    """As :func:`_returned`, with an effort that includes what the method evaluates outside of iterations."""
    with counting() as counts:
        state, effort = _returned(scheme, method, *arguments)
    return state, effort.including(counts)


def started(scheme: Any, problem: Any, u0: Any, v0: Any, dt: Any) -> tuple[Any, Effort]:
    """The first state of a scheme, and the effort to find it.

    Raises
    ------
    TypeError
        If ``start`` returns something other than a state and an effort.
    """
    result = _counted(scheme, "start", problem, u0, v0, dt)
    _check_motion(f"start of {type(scheme).__name__}", result[0], u0)
    return result


def stepped(scheme: Any, problem: Any, state: Any, t: Any, dt: Any) -> tuple[Any, Effort]:
    """The state of a scheme after a step, and the effort of the step.

    Raises
    ------
    TypeError
        If ``step`` returns something other than a state like the previous one and an effort.
    """
    result = _counted(scheme, "step", problem, state, t, dt)
    call = f"step of {type(scheme).__name__}"
    _check_motion(call, result[0], state.u)
    new, old = (jax.tree.flatten(value) for value in (result[0], state))
    shapes, expected = ([(jnp.shape(x), jnp.result_type(x)) for x in leaves] for leaves, _ in (new, old))
    if str(new[1]) != str(old[1]) or shapes != expected:
        raise TypeError(f"{call} must return a state like that of start, with the same fields, shapes and types.")
    return result


def incremented(scheme: Any, problem: Any, state: Any, t: Any, dt: Any) -> tuple[Any, Effort]:
    """The state of a one-step scheme after a step, with increments in place of u and v, and the effort of the step.

    Raises
    ------
    TypeError
        If ``increment`` returns something other than a named tuple with u and v, and an effort.
    """
    result = _returned(scheme, "increment", problem, state, t, dt)
    call = f"increment of {type(scheme).__name__}"
    if not hasattr(result[0], "_replace"):
        raise TypeError(f"{call} must return a named tuple with u and v, not {type(result[0]).__name__}.")
    _check_motion(call, result[0], state.u)
    return result
