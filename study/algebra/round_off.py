"""How far the round-off of its operations can move the results of a function."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax
from jax.extend import core  # this interface of JAX may change; there is no other to read a traced program

from study.algebra.arrays import Vector

#: Operations that contain a program, each with the name of its parameter that holds the program.
CALLS = {"jit": "jaxpr", "custom_jvp_call": "call_jaxpr"}

#: Operations whose results are their operands, rearranged: they have no round-off of their own.
EXACT = {"broadcast_in_dim", "concatenate", "convert_element_type", "copy", "dynamic_slice", "gather", "max", "min"}
EXACT |= {"neg", "pad", "reshape", "rev", "select_n", "slice", "squeeze", "stop_gradient", "transpose", "abs", "sign"}

#: Steps of two sequences k·step mod 1 that spread the changes over all numbers. Changes that cancel by chance with one
#: sequence do not cancel with the other.
STEPS = (0.6180339887498949, 0.4142135623730951)

#: Number of evaluations of the function.
EVALUATIONS = len(STEPS)


def sensitivity(function: Callable, x: Vector, exact: Vector) -> Vector:
    r"""Change of each result of ``function(x)`` per relative change of all numbers from which it is computed.

    The round-off of a result is about the machine precision times this sensitivity. It exceeds the machine precision
    times the result where large numbers cancel, as in the small elongation of a long bar. The entries of x and the
    results of all operations are changed by relative amounts between η and 4η, and the changes of the results are
    divided by η, the square root of the machine precision. A loop or a branch counts as one operation.

    Parameters
    ----------
    function
        Function of ``x`` with one array as its result.
    x, exact
        Argument (n,) and result of the function.
    """
    program, eta = jax.make_jaxpr(function)(x), jnp.sqrt(jnp.finfo(x.dtype).eps)

    def change(step):
        return jnp.abs(_changed(program, [x], eta, step)[0] - exact)

    # a loop, so that the changed program is compiled once
    return jnp.sum(lax.map(change, jnp.asarray(STEPS, x.dtype)), axis=0) / eta


def _changed(program: core.ClosedJaxpr, arguments: Sequence, eta: jax.Array, step: jax.Array) -> list:
    """Results of a program whose arguments and operations have relative changes between η and 4η."""
    jaxpr, values = program.jaxpr, dict[Any, Any]()
    count = 0

    def changed(x):
        nonlocal count
        count += 1
        if not jnp.issubdtype(jnp.result_type(x), jnp.floating):
            return x
        spread = 1 + jnp.arange(jnp.size(x), dtype=step.dtype).reshape(jnp.shape(x)) * step % 1.0
        return x * (1 + eta * (1 + count * step % 1.0) * spread).astype(jnp.result_type(x))

    def value(atom):
        return atom.val if isinstance(atom, core.Literal) else values[atom]

    values |= zip(jaxpr.constvars, program.consts, strict=True)
    values |= zip(jaxpr.invars, map(changed, arguments), strict=True)
    for equation in jaxpr.eqns:
        name = equation.primitive.name
        if name in CALLS:
            results = _changed(equation.params[CALLS[name]], [value(atom) for atom in equation.invars], eta, step)
        else:
            inputs = list({atom: None for atom in equation.invars if not isinstance(atom, core.Literal)})
            single = jaxpr.replace(constvars=[], invars=inputs, outvars=equation.outvars, eqns=[equation])
            results = core.jaxpr_as_fun(core.ClosedJaxpr(single, []))(*map(value, inputs))
            results = results if name in EXACT else list(map(changed, results))
        values |= zip(equation.outvars, results, strict=True)
    return [value(atom) for atom in jaxpr.outvars]
