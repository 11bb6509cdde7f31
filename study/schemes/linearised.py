"""A scheme with the derivative of its own map along: how fast neighbouring runs part."""

from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from study.schemes.scheme import Scheme

#: Powers of two by which a distance is brought back near one: exact, and far from both ends of the numbers, single
#: precision too.
POWER = 60


class Neighbours(NamedTuple):
    """State of the scheme, and the distance δ of a neighbour as ``distance`` · 2 to the power of ``exponent``."""

    inner: Any
    distance: Any
    exponent: jax.Array

    @property
    def u(self):
        """Displacement."""
        return self.inner.u

    @property
    def v(self):
        """Velocity."""
        return self.inner.v


class Linearised(Scheme):
    """Another scheme with a neighbour infinitely close to its run.

    With y₁ = Φ(y₀) the step of the scheme in its whole state, δ₁ = DΦ(y₀) δ₀ by automatic differentiation, from what a
    change of the displacements by a vector of length one makes of the first state. Where |δ| leaves [2⁻⁶⁰, 2⁶⁰] it is
    brought back by this power of two, without round-off.

    Parameters
    ----------
    scheme
        Any scheme.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems and for Hamiltonian systems; a method for computing all of them, Meccanica 15, 1980, 9-30.
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
        # any direction but a special one: all unknowns alike would be a translation of a free structure
        direction = jnp.cos(jnp.arange(u0.size, dtype=u0.dtype)).reshape(u0.shape)
        inner, distance, effort = jax.jvp(
            lambda u0: self.scheme.start(problem, u0, v0, dt),
            (u0,),
            (direction / jnp.sqrt(jnp.sum(direction * direction)),),
            has_aux=True,
        )
        return Neighbours(inner, distance, jnp.zeros_like(dt)), effort

    def step(self, problem, state, t, dt):
        inner, distance, effort = jax.jvp(
            lambda inner: self.scheme.step(problem, inner, t, dt), (state.inner,), (state.distance,), has_aux=True
        )
        largest = jnp.stack([jnp.max(jnp.abs(part)) for part in jax.tree.leaves(distance)]).max()
        too_far, too_near = largest > 2.0**POWER, largest < 2.0**-POWER
        factor = jnp.where(too_far, 2.0**-POWER, jnp.where(too_near, 2.0**POWER, 1.0))
        taken = jnp.where(too_far, POWER, jnp.where(too_near, -POWER, 0.0))
        return Neighbours(inner, jax.tree.map(lambda part: part * factor, distance), state.exponent + taken), effort
