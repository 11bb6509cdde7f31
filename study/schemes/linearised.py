"""A scheme with the derivative of its own map along: how fast neighbouring runs part."""

from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from study.equilibrium import Effort
from study.schemes.scheme import Scheme


class Neighbours(NamedTuple):
    """State of the scheme, direction in which a neighbour lies (of length one), and logarithm of how far it has gone."""

    inner: Any
    direction: Any
    growth: jax.Array

    @property
    def u(self):
        """Displacement."""
        return self.inner.u

    @property
    def v(self):
        """Velocity."""
        return self.inner.v


def _unit(direction):
    """The direction with length one, and its length before."""
    length = jnp.sqrt(sum(jnp.sum(part * part) for part in jax.tree.leaves(direction)))
    return jax.tree.map(lambda part: part / length, direction), length


class Linearised(Scheme):
    """Another scheme that carries a neighbour infinitely close to each state.

    With y₁ = Φ(y₀) the step of the scheme in its whole state, w₁ = DΦ(y₀) w₀ by automatic differentiation, brought back
    to length one in every step; the sum of ln |w₁| over time tends to the largest Lyapunov exponent of the map.

    Parameters
    ----------
    scheme
        Any scheme.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical systems
    and for Hamiltonian systems; a method for computing all of them, Meccanica 15, 1980, 9-30.
    """

    scheme: Scheme
    title: str = eqx.field(default="Linearised", kw_only=True, static=True)

    family: ClassVar[str] = "Linearised"
    source: ClassVar[str] = "Benettin et al. (1980)"
    doi: ClassVar[str] = "10.1007/BF02128236"

    @property
    def order(self) -> int:
        return self.scheme.order

    @property
    def explicit(self) -> bool:
        return self.scheme.explicit

    @property
    def needs_mass(self) -> bool:
        return self.scheme.needs_mass

    def start(self, problem, u0, v0, dt):
        inner, effort = self.scheme.start(problem, u0, v0, dt)
        direction, _ = _unit(jax.tree.map(jnp.ones_like, inner))
        return Neighbours(inner, direction, jnp.zeros_like(dt)), effort

    def step(self, problem, state, t, dt) -> tuple[Neighbours, Effort]:
        inner, direction, effort = jax.jvp(
            lambda inner: self.scheme.step(problem, inner, t, dt), (state.inner,), (state.direction,), has_aux=True
        )
        direction, length = _unit(direction)
        return Neighbours(inner, direction, state.growth + jnp.log(length)), effort
