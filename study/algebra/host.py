"""NumPy functions inside compiled programs.

The public ``jax.pure_callback`` converts the arguments to arrays of JAX. With large arrays and few cores, this
conversion waits for a thread that waits for the callback: a deadlock. ``emit_python_callback``, which ``pure_callback``
calls, passes NumPy arrays. Only this module uses ``jax.interpreters``, which JAX may change in any release.
"""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import mlir

_on_host = Primitive("on_host")


def _silent(function, arrays):
    """Call a function with NumPy's warnings suppressed, because the status of a run reports an overflow."""
    with np.errstate(all="ignore"):
        return function(*arrays)


@_on_host.def_abstract_eval
def _shape(*arguments, function, result):
    return result


@_on_host.def_impl
def _at_once(*arguments, function, result):
    return jnp.asarray(_silent(function, map(np.asarray, arguments)), result.dtype)


def _lowered(context, *arguments, function, result):
    results, *_ = mlir.emit_python_callback(
        context,
        lambda *arrays: (_silent(function, arrays),),
        None,
        list(arguments),
        context.avals_in,
        context.avals_out,
        has_side_effect=False,
    )
    return results


mlir.register_lowering(_on_host, _lowered)


def on_host(function: Callable, like: jax.Array, *arguments: jax.Array) -> jax.Array:
    """Result of ``function(*arguments)``, with the shape and type of ``like``; a batch takes one call per lane.

    Parameters
    ----------
    function
        Function that takes NumPy arrays and returns one. It must not keep or change its arguments, and must have no
        side effects, because the compiler decides how often it is called.
    """
    result = ShapedArray(like.shape, like.dtype)
    return jax.custom_batching.sequential_vmap(lambda *xs: _on_host.bind(*xs, function=function, result=result))(
        *arguments
    )
