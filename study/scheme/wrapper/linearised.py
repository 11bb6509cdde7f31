"""A scheme together with the derivative of its map, which measures how fast neighbouring runs diverge."""

from typing import Any, ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jax import lax

from study.scheme.base import Scheme, Wrapper, WrapperState


class Neighbours(WrapperState):
    """State of the wrapped scheme, and its distance δ = ``distance`` · 2^``exponent`` from a neighbouring state."""

    distance: Any
    exponent: jax.Array
    inner: Any

    @property
    def history(self) -> Any:
        """History of the force, if the scheme commits one."""
        return self.inner.history


def _power_of_two(size):
    """The p with 2ᵖ ≤ size < 2ᵖ⁺¹, and 2⁻ᵖ, from the bits of ``size`` > 0. A logarithm would take ten times longer."""
    number = jnp.finfo(size.dtype)
    bias = number.maxexp - 1
    biased = lax.bitcast_convert_type(size, f"int{number.bits}") >> number.nmant
    biased = jnp.clip(biased, 1, 2 * bias - 1)  # the factor stays finite if the size under- or overflows
    # An exact division. XLA does not duplicate divisions, so it computes ``size`` once, not for each scaled number.
    return (biased - bias).astype(int), 1 / lax.bitcast_convert_type(biased << number.nmant, size.dtype)


class Linearised(Wrapper):
    """Another scheme together with a neighbouring run at an infinitesimal distance δ.

    Let y₁ = Φ(y₀) be a step of the wrapped scheme in its whole state. The distance follows δ₁ = DΦ(y₀) δ₀, computed by
    automatic differentiation. The first δ is the derivative of the first state along a unit vector of initial
    displacements. After every step δ is divided by a power of two, without round-off, so that the largest component of
    the displacement and velocity of δ lies between 1 and 2. Order and stability are those of the wrapped scheme.
    Carries the state of the wrapped scheme, δ and the sum of the exponents; one additional Jacobian-vector product per
    step.

    Parameters
    ----------
    scheme
        Any scheme.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems and for Hamiltonian systems; a method for computing all of them. Part 2: numerical application, Meccanica
    15(1), 1980, 21-30.
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents for smooth dynamical
    systems and for Hamiltonian systems; a method for computing all of them. Part 1: theory, Meccanica 15(1), 1980,
    9-20.
    """

    scheme: Scheme
    title: str = eqx.field(default="Linearised", static=True)

    family: ClassVar[str] = "Linearised"
    source: ClassVar[str] = "Benettin et al. (1980)"
    doi: ClassVar[str] = "10.1007/BF02128237"

    def start(self, problem, u0, v0, dt):
        # an arbitrary direction; equal components, for example, would be the translation of a free structure
        direction = jnp.cos(jnp.arange(u0.size, dtype=u0.dtype)).reshape(u0.shape)
        inner, distance, effort = jax.jvp(
            lambda u0: self.scheme.start(problem, u0, v0, dt),
            (u0,),
            (direction / jnp.sqrt(jnp.sum(direction * direction)),),
            has_aux=True,
        )
        return Neighbours(distance, jnp.zeros((), int), inner), effort

    def step(self, problem, state, t, dt):
        inner, distance, effort = jax.jvp(
            lambda inner: self.scheme.step(problem, inner, t, dt), (state.inner,), (state.distance,), has_aux=True
        )
        size = jnp.maximum(jnp.max(jnp.abs(distance.u)), jnp.max(jnp.abs(distance.v)))
        power, factor = _power_of_two(size)
        distance = jax.tree.map(lambda part: part * factor, distance)
        return Neighbours(distance, state.exponent + power, inner), effort
