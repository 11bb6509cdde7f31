"""A warning where JAX computes a derivative that is NaN."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from study.warn import warn


def _warn(is_nan, *, message: str) -> None:
    if is_nan.any():  # lanes of a ``vmap`` are reported together
        warn(message)


def _checked(x, *, message: str):
    _warn(jnp.isnan(x), message=message)
    return x


def _checked_in_program(x, *, message: str):
    is_nan = jnp.isnan(x).any()
    jax.lax.cond(is_nan, partial(jax.debug.callback, partial(_warn, message=message)), lambda _: None, is_nan)
    return x


#: The identity on tangents and cotangents, which warns of NaN when it is computed.
_identity = Primitive("watched")
_identity.def_impl(_checked)
_identity.def_abstract_eval(lambda x, **_: x)
mlir.register_lowering(_identity, mlir.lower_fun(_checked_in_program, multiple_results=False))
batching.defvectorized(_identity)
ad.deflinear2(_identity, lambda cotangent, x, **message: [_identity.bind(cotangent, **message)])


@partial(jax.custom_jvp, nondiff_argnums=(1,))
def _watched(x, message: str):
    return x


@_watched.defjvp
def _derivative(message, primals, tangents):
    return _watched(*primals, message), _identity.bind(*tangents, message=message)


def watched(values: Any, message: str) -> Any:
    """The values, with a ``RuntimeWarning`` if their tangents (in forward mode) or cotangents (in reverse) are NaN.

    The warning is given when the derivatives are computed, also in compiled programs and in lanes of ``jax.vmap``.
    Integers are returned unchanged.
    """
    return jax.tree.map(lambda x: _watched(x, message) if jnp.issubdtype(x.dtype, jnp.floating) else x, values)
