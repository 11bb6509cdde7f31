"""Arguments of an internal force, its kinks, and whether it depends on the velocity."""

import inspect
from collections.abc import Callable
from functools import partial
from itertools import islice
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.extend import core  # this interface of JAX may change; there is no other to read a traced program
from jaxtyping import Array, Float

from study.algebra.scalars import check_unmasked

#: Operations whose value or slope may jump at some values of their arguments.
KINKS = {"abs", "sign", "max", "min", "clamp", "floor", "ceil", "round", "rem", "while"}
KINKS |= {"reduce_max", "reduce_min", "cummax", "cummin", "sort", "top_k"}
#: Operation that turns the result of a comparison into a number, as in ``u * (u > 0)``.
CONVERSION = "convert_element_type"
#: Operations that select one of several values or branches by their first argument.
BRANCHES = {"select_n", "cond"}


#: Names by which a parameter of a force is the time.
TIME = ("t", "time")
#: Names by which the author of a force means the displacement, and the velocity.
DISPLACEMENT, VELOCITY = ("u", "disp", "displacement"), ("v", "vel", "velocity", "du", "udot", "u_dot")


def _needed(force: Callable) -> list[str]:
    """Names of a force's parameters that have no default."""
    try:
        parameters = inspect.signature(force).parameters.values()
    except (TypeError, ValueError):  # built-in functions have no signature
        return []
    kinds = inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD
    return [
        parameter.name for parameter in parameters if parameter.default is parameter.empty and parameter.kind in kinds
    ]


def place_of_time(force: Callable) -> int | None:
    """Place of the time among a force's arguments; None if the force does not take it."""
    return next((place for place, name in enumerate(_needed(force)) if name in TIME), None)


def number_of_arguments(force: Callable) -> int:
    """Number of a force's arguments except the time: 1 for p(u), 2 for p(u, u̇), 3 for a force with a history."""
    return max(len(_needed(force)) - (place_of_time(force) is not None), 1)


def check_signature(force: Callable, arguments: int, history: Any, title: str) -> None:
    """Refuse a number of arguments that does not fit the history, and a velocity before the displacement."""
    if arguments > 3 or (arguments == 3) != (history is not None):
        kept = "a history" if history is not None else "no history"
        raise ValueError(
            f"force of '{title}' takes {arguments} arguments, and the problem has {kept}: give force(u), force(u, v), "
            "or force(u, v, history) with Problem(history=...), and a further argument t if the force takes the time."
        )
    first, second, *_ = [*_needed(force), "", ""]
    if first in VELOCITY and second in DISPLACEMENT:
        raise ValueError(
            f"force of '{title}' takes {first} and {second}: its first argument is the displacement, and its second "
            "the velocity, whatever their names."
        )


def as_history(start: Any, title: str) -> Any:
    """A history at rest as float64 arrays.

    Raises
    ------
    ValueError
        If it holds no arrays, or values other than finite real numbers.
    """
    leaves, structure = jax.tree.flatten(start)
    for leaf in leaves:
        check_unmasked(f"the history of '{title}'", leaf)
    arrays = [np.asarray(leaf) if not isinstance(leaf, jax.core.Tracer) else leaf for leaf in leaves]
    if not leaves or any(array.dtype.kind not in "fiu" for array in arrays):
        raise ValueError(f"the history of '{title}' must be arrays of real numbers, in any containers, not {start!r}.")
    if any(isinstance(array, np.ndarray) and not np.isfinite(array).all() for array in arrays):
        raise ValueError(f"the history of '{title}' must be finite, not {start!r}.")
    return jax.tree.unflatten(structure, [array.astype(np.float64) for array in arrays])


def _inner(equation: core.JaxprEqn) -> list[core.Jaxpr]:
    """Programs inside an operation."""
    kinds = core.Jaxpr | core.ClosedJaxpr
    parts = jax.tree.leaves(list(equation.params.values()), is_leaf=lambda x: isinstance(x, kinds))
    return [part.jaxpr if isinstance(part, core.ClosedJaxpr) else part for part in parts if isinstance(part, kinds)]


def _kinked(jaxpr: core.Jaxpr, depends: list[bool]) -> tuple[bool, list[bool]]:
    """Whether a program has a kink in the marked arguments, and for each result whether it depends on them.

    ``depends`` marks the arguments.
    """
    marked = {variable for variable, does in zip(jaxpr.invars, depends, strict=True) if does}
    kinked = False
    for equation in jaxpr.eqns:
        flags = [not isinstance(x, core.Literal) and x in marked for x in equation.invars]
        name, results = equation.primitive.name, [any(flags)] * len(equation.outvars)
        kinked |= (name in KINKS and any(flags)) or (name in BRANCHES and flags[0])
        kinked |= name == CONVERSION and flags[0] and equation.invars[0].aval.dtype == bool  # type: ignore[attr-defined]
        for inner in _inner(equation) if any(flags) else ():
            same = len(inner.invars) == len(flags)
            inside, inner_results = _kinked(inner, flags if same else [True] * len(inner.invars))
            kinked |= inside
            if same and len(inner_results) == len(results):
                results = inner_results
        marked.update(out for out, does in zip(equation.outvars, results, strict=True) if does)
    return kinked, [not isinstance(x, core.Literal) and x in marked for x in jaxpr.outvars]


def _program(force: Callable, arguments: tuple) -> core.Jaxpr:
    """The traced program of a force."""
    return eqx.filter_make_jaxpr(force)(*map(jnp.asarray, arguments))[0].jaxpr


def may_have_kinks(force: Callable, *arguments: Any) -> bool:
    """Whether the force branches on an argument, multiplies by a comparison, or applies an operation of ``KINKS``.

    A square root, as in the length of a bar, counts as smooth, although it has a kink where its argument is zero.
    """
    program = _program(force, arguments)
    return _kinked(program, [True] * len(program.invars))[0]


#: For comparisons and some operations with a kink: a function of the operands, whose results change sign at the kink.
_SWITCHES: dict[str, Callable] = dict.fromkeys(("lt", "le", "gt", "ge", "max", "min"), lambda a, b: [a - b])
_SWITCHES |= dict.fromkeys(("abs", "sign"), lambda a: [a])
_SWITCHES["clamp"] = lambda low, a, high: [a - low, a - high]
#: Operations that contain a program, each with the name of its parameter that holds the program.
_CALLS = {"jit": "jaxpr", "custom_jvp_call": "call_jaxpr"}


def _switches(program: core.ClosedJaxpr, depends: list[bool], *arguments: Array) -> list[Array]:
    """As :func:`switches`, for a traced program, and only for the arguments that ``depends`` marks."""
    jaxpr = program.jaxpr
    marked = {variable for variable, does in zip(jaxpr.invars, depends, strict=True) if does}
    sources = []
    for equation in jaxpr.eqns:
        flags = [not isinstance(x, core.Literal) and x in marked for x in equation.invars]
        name = equation.primitive.name
        if any(flags):
            marked.update(equation.outvars)
            # integers, such as indices into a table, are left out: they jump, and no change of sign locates the kink
            if name in _SWITCHES and all(jnp.issubdtype(x.aval.dtype, jnp.floating) for x in equation.invars):
                sources.append((_SWITCHES[name], equation.invars))
            elif name in _CALLS:
                sources.append((partial(_switches, equation.params[_CALLS[name]], flags), equation.invars))
    # the same program, with the operands of these operations as its results
    operands = [operand for _, operands in sources for operand in operands]
    required, kept = {x for x in operands if not isinstance(x, core.Literal)}, list[core.JaxprEqn]()
    for equation in reversed(jaxpr.eqns):
        if not required.isdisjoint(equation.outvars):
            kept.insert(0, equation)
            required |= {x for x in equation.invars if not isinstance(x, core.Literal)}
    to_operands = core.ClosedJaxpr(jaxpr.replace(eqns=kept, outvars=operands), program.consts)
    values = iter(core.jaxpr_as_fun(to_operands)(*arguments))
    return [switch for function, operands in sources for switch in function(*islice(values, len(operands)))]


def switches(force: Callable, *arguments: Any) -> Float[Array, "switches"]:
    """Numbers whose sign changes where the slope of a force may jump.

    Where the force compares two numbers, or takes the larger or smaller of them, their difference is returned. Where
    it takes the absolute value or the sign of a number, that number is returned. Loops, branches and tables are not
    searched.

    Parameters
    ----------
    arguments
        Displacement, or displacement and velocity.
    """
    inputs = list(map(jnp.asarray, arguments))
    program = eqx.filter_make_jaxpr(force)(*inputs)[0]
    differences = _switches(program, [True] * len(program.jaxpr.invars), *inputs)
    return jnp.concatenate([jnp.zeros(0), *(jnp.ravel(switch).astype(float) for switch in differences)])


def numbers(function: Callable, *arguments: Any) -> np.ndarray:
    """The real numbers that occur in the traced program of a function, as constants or in tables, each once."""
    program = eqx.filter_make_jaxpr(function)(*map(jnp.asarray, arguments))[0]
    values = [np.zeros(0), *map(np.ravel, program.consts)]

    def collect(jaxpr: core.Jaxpr) -> None:
        for equation in jaxpr.eqns:
            values.extend(np.ravel(x.val) for x in equation.invars if isinstance(x, core.Literal))
            for inner in _inner(equation):
                collect(inner)

    collect(program.jaxpr)
    return np.unique(np.concatenate([array.astype(float) for array in values if array.dtype.kind in "fiu"]))


def depends_on_last(force: Callable, *arguments: Any) -> bool:
    """Whether the force depends on its last argument."""
    program = _program(force, arguments)
    return any(_kinked(program, [False] * (len(program.invars) - 1) + [True])[1])
