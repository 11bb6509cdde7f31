"""Equation (1): M ü + C u̇ + p(u) = f(t), with u(0) and u̇(0)."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np


def _real(value):
    """Float64 for numbers and arrays; what JAX is tracing stays as it is."""
    if isinstance(value, jax.core.Tracer):
        return value
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"a problem takes numbers and arrays of numbers, not {value!r}.") from None


def _optional_real(value):
    return None if value is None else _real(value)


class Problem(eqx.Module):
    """A second-order initial value problem M ü + C u̇ + p(u) = f(t), Xie (1996), eq. (1).

    Everything but ``force``, ``u0`` and ``v0`` is optional, and what is absent costs nothing: no such term is in
    the compiled loop.

    Parameters
    ----------
    force
        Internal force p(u), written with ``jax.numpy``; returns the shape of ``u``.
    u0, v0
        Displacement and velocity at t = 0, both of shape () or (n,).
    potential
        V(u) with p = ∂V/∂u, a scalar. Needed only where an energy is asked for.
    mass, damping
        M and C: a number, a diagonal (n,) or a matrix (n, n). Absent, M is the identity and C is zero.
    load
        f(t), of the shape of ``u``.
    title
        What figures and datasets call it.

    Raises
    ------
    ValueError, TypeError
        If the shapes do not fit each other, a number is not finite, or a function is none.
    """

    force: Callable
    u0: Any = eqx.field(converter=_real)
    v0: Any = eqx.field(converter=_real, default=0.0)
    potential: Callable | None = eqx.field(default=None, kw_only=True)
    mass: Any = eqx.field(converter=_optional_real, default=None, kw_only=True)
    damping: Any = eqx.field(converter=_optional_real, default=None, kw_only=True)
    load: Callable | None = eqx.field(default=None, kw_only=True)
    title: str = eqx.field(default="unnamed problem", kw_only=True, static=True)

    def __check_init__(self):
        shape = np.shape(self.u0)
        if len(shape) > 1 or shape == (0,):
            raise ValueError(f"u0 must be a number or a vector (n,), not an array of shape {shape}.")
        if np.shape(self.v0) != shape:
            raise ValueError(f"v0 must have the shape of u0, {shape}, not {np.shape(self.v0)}.")
        allowed = {(), shape, shape * 2}
        for name in ("mass", "damping"):
            value = getattr(self, name)
            if value is not None and np.shape(value) not in allowed:
                raise ValueError(
                    f"{name} must be a number, a diagonal or a matrix for u0 of shape {shape}; got {np.shape(value)}."
                )
        for name, values, expected in (
            ("force", (self.u0,), shape),
            ("load", (0.0,), shape),
            ("potential", (self.u0,), ()),
        ):
            function = getattr(self, name)
            if not callable(function) and (function is not None or name == "force"):
                raise TypeError(f"{name} must be a function, not {function!r}.")
            if function is not None:
                received = jax.eval_shape(lambda *x, f=function: jnp.asarray(f(*x)), *values).shape
                if received != expected:
                    raise ValueError(f"{name} must return the shape {expected}, not {received}.")
        for name in ("u0", "v0", "mass", "damping"):
            value = getattr(self, name)
            if isinstance(value, np.ndarray) and not np.isfinite(value).all():
                raise ValueError(f"{name} must be finite, not {value}.")
        if isinstance(self.mass, np.ndarray):
            least = np.linalg.eigvalsh(self.mass).min() if self.mass.ndim == 2 else self.mass.min()
            if least <= 0:
                raise ValueError(f"mass must be positive (definite); its smallest value is {least:g}.")

    def energy(self, u, v):
        """Kinetic and potential energy ½ u̇ᵀ M u̇ + V(u), the scalar E of Xie (1996), eqs (4) and (5)."""
        if self.potential is None:
            raise ValueError(f"the energy of '{self.title}' needs its potential: give Problem(potential=...).")
        momentum = v if self.mass is None else self.mass @ v if np.ndim(self.mass) == 2 else self.mass * v
        return 0.5 * jnp.vdot(v, momentum) + self.potential(u)
