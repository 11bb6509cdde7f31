"""What an internal force depends on, and whether its slope may jump: both are read off what it computes."""

import inspect
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.extend import core

#: Operations whose slope jumps where they do so for no other reason than the value of their argument.
KINKS = {"abs", "sign", "max", "min", "clamp", "floor", "ceil", "round", "rem", "while"}
KINKS |= {"reduce_max", "reduce_min", "cummax", "cummin", "sort", "top_k"}
#: Operations of which the truth of a comparison becomes a number, as in ``u * (u > 0)``.
CONVERSION = "convert_element_type"
#: Operations that branch by their first argument.
BRANCHES = {"select_n", "cond"}


def number_of_arguments(force: Callable) -> int:
    """Number of arguments that a force must be given: 1 for p(u), 2 for p(u, u̇), 3 for a force with a history."""
    try:
        parameters = inspect.signature(force).parameters.values()
    except (TypeError, ValueError):  # built-in functions tell nothing
        return 1
    needed = [p for p in parameters if p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    return max(len(needed), 1)


def as_history(start: Any, title: str) -> Any:
    """A history at rest as float64 arrays.

    Raises
    ------
    ValueError
        If it holds something else than finite real numbers, or nothing.
    """
    leaves, structure = jax.tree.flatten(start)
    arrays = [np.asarray(leaf) if not isinstance(leaf, jax.core.Tracer) else leaf for leaf in leaves]
    if not leaves or any(array.dtype.kind not in "fiu" for array in arrays):
        raise ValueError(f"the history of '{title}' must be arrays of real numbers, in any containers, not {start!r}.")
    if any(isinstance(array, np.ndarray) and not np.isfinite(array).all() for array in arrays):
        raise ValueError(f"the history of '{title}' must be finite, not {start!r}.")
    return jax.tree.unflatten(structure, [array.astype(np.float64) for array in arrays])


def _inner(equation: core.JaxprEqn) -> list[core.Jaxpr]:
    """Programs inside an operation."""
    kinds = core.Jaxpr | core.ClosedJaxpr
    found = jax.tree.leaves(list(equation.params.values()), is_leaf=lambda x: isinstance(x, kinds))
    return [one.jaxpr if isinstance(one, core.ClosedJaxpr) else one for one in found if isinstance(one, kinds)]


def _kinked(jaxpr: core.Jaxpr, depends: list[bool]) -> tuple[bool, list[bool]]:
    """Whether a program has a kink in those arguments that ``depends`` marks, and which results depend on them."""
    marked = {variable for variable, does in zip(jaxpr.invars, depends, strict=True) if does}
    kinked = False
    for equation in jaxpr.eqns:
        given = [not isinstance(x, core.Literal) and x in marked for x in equation.invars]
        name, results = equation.primitive.name, [any(given)] * len(equation.outvars)
        kinked |= (name in KINKS and any(given)) or (name in BRANCHES and given[0])
        kinked |= name == CONVERSION and given[0] and equation.invars[0].aval.dtype == bool  # type: ignore[attr-defined]
        for inner in _inner(equation) if any(given) else ():
            same = len(inner.invars) == len(given)
            inside, found = _kinked(inner, given if same else [True] * len(inner.invars))
            kinked |= inside
            if same and len(found) == len(results):
                results = found
        marked.update(out for out, does in zip(equation.outvars, results, strict=True) if does)
    return kinked, [not isinstance(x, core.Literal) and x in marked for x in jaxpr.outvars]


def _program(force: Callable, arguments: tuple) -> core.Jaxpr:
    """What a force computes, as a program of its arguments and the arrays in it."""
    return eqx.filter_make_jaxpr(force)(*map(jnp.asarray, arguments))[0].jaxpr


def may_have_kinks(force: Callable, *arguments: Any) -> bool:
    """Whether the force branches by an argument, or takes its size, its sign, or the larger of two values of it.

    A root is taken for smooth, as in the length of a bar, although it has a kink where its argument is zero.
    """
    program = _program(force, arguments)
    return _kinked(program, [True] * len(program.invars))[0]


def depends_on_last(force: Callable, *arguments: Any) -> bool:
    """Whether the force depends on its last argument."""
    program = _program(force, arguments)
    return any(_kinked(program, [False] * (len(program.invars) - 1) + [True])[1])
