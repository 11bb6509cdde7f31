"""Checks of the contract of a scheme: JAX can trace its functions, which return a state with u and v and an effort."""

from typing import Any

import jax
import jax.numpy as jnp

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
    of = type(scheme).__name__
    if not isinstance(scheme.title, str) or not scheme.title.strip():
        raise TypeError(f"title of {of} must be a non-blank string, not {scheme.title!r}.")
    for name in ("order", "order_with_damping"):
        try:
            value = getattr(scheme, name)
        except Exception as error:  # a property of a user's scheme may raise any exception
            raise TypeError(f"{name} of {of} raises {type(error).__name__}: {error}") from error
        if not is_whole(value, 1):
            raise TypeError(f"{name} of {of} must be a whole number of at least 1, not {value!r}.")
    limit = scheme.stability_limit
    if limit is not None and not (is_number(limit) and limit >= 0):
        raise TypeError(f"stability_limit of {of} must be a number of at least 0 or None, not {limit!r}.")


def _returned(scheme: Any, method: str, *arguments: Any) -> tuple[Any, Effort]:
    """Result of a method of a scheme, checked to be a pair of a state and an effort."""
    of = f"{method} of {type(scheme).__name__}"
    try:
        returned = getattr(scheme, method)(*arguments)
    except NOT_TRACEABLE as error:
        raise TypeError(
            f"{of} branches on a number that JAX traces, or passes it to NumPy or Python: write it with jax.numpy, and "
            "use jnp.where for a choice."
        ) from error
    except (AttributeError, NameError, RuntimeError) as error:
        raise TypeError(f"{of} raises {type(error).__name__}: {error}") from error
    if not (isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[1], Effort)):
        raise TypeError(f"{of} must return a state and a study.building.Effort, not {type(returned).__name__}.")
    if None in (returned[1].iterations, returned[1].converged):
        raise TypeError(f"{of} must return a study.building.Effort with iterations and converged, not {returned[1]!r}.")
    return returned


def _check_motion(of: str, state: Any, u: Any) -> None:
    for name in ("u", "v"):
        if not hasattr(state, name) or jnp.shape(getattr(state, name)) != u.shape:
            raise TypeError(f"{of} must return a state with '{name}' of shape {u.shape}.")
        if (kind := jnp.result_type(getattr(state, name))) != u.dtype:
            raise TypeError(f"{of} must return '{name}' in {u.dtype}, not in {kind}.")


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
    returned = _counted(scheme, "start", problem, u0, v0, dt)
    _check_motion(f"start of {type(scheme).__name__}", returned[0], u0)
    return returned


def stepped(scheme: Any, problem: Any, state: Any, t: Any, dt: Any) -> tuple[Any, Effort]:
    """The state of a scheme after a step, and the effort of the step.

    Raises
    ------
    TypeError
        If ``step`` returns something other than a state like the previous one and an effort.
    """
    returned = _counted(scheme, "step", problem, state, t, dt)
    of = f"step of {type(scheme).__name__}"
    _check_motion(of, returned[0], state.u)
    new, old = (jax.tree.flatten(one) for one in (returned[0], state))
    shapes, wanted = ([(jnp.shape(x), jnp.result_type(x)) for x in leaves] for leaves, _ in (new, old))
    if str(new[1]) != str(old[1]) or shapes != wanted:
        raise TypeError(f"{of} must return a state like that of start, with the same fields, shapes and types.")
    return returned


def incremented(scheme: Any, problem: Any, state: Any, t: Any, dt: Any) -> tuple[Any, Effort]:
    """The state of a one-step scheme after a step, with increments in place of u and v, and the effort of the step.

    Raises
    ------
    TypeError
        If ``increment`` returns something other than a named tuple with u and v, and an effort.
    """
    returned = _returned(scheme, "increment", problem, state, t, dt)
    of = f"increment of {type(scheme).__name__}"
    if not hasattr(returned[0], "_replace"):
        raise TypeError(f"{of} must return a named tuple with u and v, not {type(returned[0]).__name__}.")
    _check_motion(of, returned[0], state.u)
    return returned
