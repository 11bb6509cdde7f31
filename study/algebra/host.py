"""NumPy functions inside compiled programs."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import batching, mlir

_on_host = Primitive("on_host")


def _silent(function, arrays):
    """The result of a function; a run that grows beyond all numbers says so by its status."""
    with np.errstate(all="ignore"):
        return function(*arrays)


@_on_host.def_abstract_eval
def _shape(*arguments, function, result):
    return result


@_on_host.def_impl
def _at_once(*arguments, function, result):
    return jnp.asarray(_silent(function, map(np.asarray, arguments)), result.dtype)


def _lowered(context, *arguments, function, result):
    called, *_ = mlir.emit_python_callback(
        context,
        lambda *arrays: (_silent(function, arrays),),
        None,
        list(arguments),
        context.avals_in,
        context.avals_out,
        has_side_effect=False,
        returns_token=False,
    )
    return called


def _one_by_one(arguments, axes, *, function, result):
    lanes = next(x.shape[axis] for x, axis in zip(arguments, axes, strict=True) if axis is not None)
    moved = [x if axis is None else jnp.moveaxis(x, axis, 0) for x, axis in zip(arguments, axes, strict=True)]

    def of_lane(lane):
        return _on_host.bind(
            *(x if axis is None else x[lane] for x, axis in zip(moved, axes, strict=True)),
            function=function,
            result=result,
        )

    return jax.lax.map(of_lane, jnp.arange(lanes)), 0


mlir.register_lowering(_on_host, _lowered)
batching.primitive_batchers[_on_host] = _one_by_one


def on_host(function: Callable, like: jax.Array, *arguments: jax.Array) -> jax.Array:
    """``function(*arguments)``, of the shape and type of ``like``; lanes are taken one by one.

    ``jax.pure_callback`` does the same, but makes arrays of JAX of the arguments. That waits for a thread which, with
    large arrays and few cores, waits for the callback: the program would stand still for ever.

    Parameters
    ----------
    function
        Takes and returns NumPy arrays, and must not keep or change the ones that it is given. It must have no other
        effect that matters: it is called as often as the compiler likes.
    """
    return _on_host.bind(*arguments, function=function, result=ShapedArray(like.shape, like.dtype))
