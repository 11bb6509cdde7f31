"""Materials that yield, slip, damp or touch, as force of one unknown or as elements of a structure.

A material is the force of one unknown, or with :func:`elements` the force of every spring of a structure::

    spring = study.materials.elastoplastic(stiffness=4.0, yield_force=1.0, hardening=0.05)
    oscillator = study.Problem(spring, u0=0.0, potential=spring.potential, load=load)

Parameters may be arrays with one value for each element. A material with a memory has an attribute ``history`` and
returns the new history with its force. Forces are exact for the straight motion from the last committed displacement to
u, so that the material adds no error to that of the scheme.
"""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from study.algebra.arrays import Vector, as_float64
from study.algebra.scalars import is_whole
from study.keywords import KeywordsOnly, keywords_only
from study.mechanics.internal_force import number_of_arguments


def _check(name: str, value: Any, low: float, strict: bool, high: float = np.inf) -> None:
    """Refuse a parameter unless it is a finite number in its range or an array of such numbers."""
    if isinstance(value, jax.core.Tracer):
        return
    numbers = np.asarray(value)
    real = numbers.dtype.kind in "fiu" and np.isfinite(numbers).all()
    if not real or not np.all((numbers > low if strict else numbers >= low) & (numbers <= high)):
        limits = f"greater than {low:g}" if strict else f"at least {low:g}"
        limits = "that is finite" if np.isinf(low) else limits
        limits += "" if np.isinf(high) else f" and at most {high:g}"
        raise ValueError(f"{name} must be a number {limits}, not {numbers.tolist()!r}.")


def _check_shapes(**parameters: Any) -> None:
    """Refuse parameters whose shapes belong to different numbers of elements."""
    shapes = {name: np.shape(value) for name, value in parameters.items()}
    if len({shape for shape in shapes.values() if shape != ()}) > 1:
        each = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"parameters must be numbers or arrays of one shape, a value for each element, not {each}.")


class Elastoplastic(KeywordsOnly, eqx.Module):
    r"""An elastoplastic spring with linear kinematic hardening, the bilinear spring of structural codes.

    .. math::

        p = b k u + (1 - b)\,k e, \quad e = u - u_p, \quad |e| \le u_y = p_y/k

    The history is the plastic displacement u_p, which changes only where e would leave its bounds (return mapping). The
    stored energy is :math:`\tfrac12 b k u^2 + \tfrac12 (1 - b)\,k e^2`.

    References
    ----------
    J. C. Simo, T. J. R. Hughes, Computational inelasticity, Springer, 1998, section 1.4.
    """

    stiffness: Any = eqx.field(converter=as_float64)
    yield_force: Any = eqx.field(converter=as_float64)
    hardening: Any = eqx.field(converter=as_float64)

    @property
    def history(self) -> np.ndarray:
        """Zero plastic displacement."""
        return np.zeros(np.broadcast_shapes(*map(np.shape, (self.stiffness, self.yield_force, self.hardening))))

    def _elastic(self, u, plastic):
        bound, trial = self.yield_force / self.stiffness, u - plastic
        return jnp.where(trial > bound, bound, jnp.where(trial < -bound, -bound, trial))

    def __call__(self, u, v, history):
        """Force p at displacement u, and the plastic displacement u_p after the motion to u."""
        elastic = self._elastic(u, history)
        force = self.stiffness * (self.hardening * u + (1 - self.hardening) * elastic)
        return force, u - elastic

    def potential(self, u, history):
        """Stored energy ½ b k u² + ½ (1 − b) k e², summed over elements."""
        elastic = self._elastic(u, history)
        stored = self.hardening * u**2 + (1 - self.hardening) * elastic**2
        return jnp.sum(self.stiffness * stored) / 2


@keywords_only
def elastoplastic(*, stiffness, yield_force, hardening=0.0) -> Elastoplastic:
    """An elastoplastic spring: stiffness k, yield force p_y, and ratio b of the stiffness after yield to k.

    Raises
    ------
    ValueError
        If k or p_y is not greater than zero, b is not between 0 and 1, or arrays among them differ in shape.
    """
    _check("stiffness", stiffness, 0.0, strict=True)
    _check("yield_force", yield_force, 0.0, strict=True)
    _check("hardening", hardening, 0.0, strict=False, high=1.0)
    _check_shapes(stiffness=stiffness, yield_force=yield_force, hardening=hardening)
    return Elastoplastic(stiffness=stiffness, yield_force=yield_force, hardening=hardening)


@keywords_only
def friction(*, slip_force, stiffness) -> Elastoplastic:
    """Coulomb friction: a contact of the given stiffness that slips where its force reaches the slip force.

    The stiffness models the asperities. A stiff contact approximates the rigid law of Coulomb, whose force jumps and
    has no tangent. The relative difference from the motion with rigid friction is inversely proportional to the square
    root of the stiffness. The vibration period of the contact should stay well above the step size.

    Raises
    ------
    ValueError
        If the slip force or the stiffness is not greater than zero, or both are arrays of different shapes.
    """
    _check("slip_force", slip_force, 0.0, strict=True)
    _check("stiffness", stiffness, 0.0, strict=True)
    _check_shapes(slip_force=slip_force, stiffness=stiffness)
    return Elastoplastic(stiffness=stiffness, yield_force=slip_force, hardening=0.0)


class BoucWen(KeywordsOnly, eqx.Module):
    r"""The smooth hysteresis of Bouc and Wen, without a sharp yield point.

    .. math::

        p &= b k u + (1 - b)\,k z, \quad u_y = p_y/k \\
        dz &= [1 - \tfrac12 |z/u_y|^n (1 + \operatorname{sgn}(z\,du))]\,du

    Wen's β and γ are equal, so that unloading is elastic. With z = u_y y and du = s u_y dx, where s = ±1 is the
    direction of the motion, :math:`d(s y)/dx = 1 - |y|^n` for s y > 0, else 1. This equation has a closed solution for
    n = 1 and n = 2, which is used. The history holds u and y at the last commit.

    References
    ----------
    Y. K. Wen, Method for random vibration of hysteretic systems, J. Eng. Mech. Div. ASCE 102(EM2), 1976, 249-263.
    """

    stiffness: Any = eqx.field(converter=as_float64)
    yield_force: Any = eqx.field(converter=as_float64)
    hardening: Any = eqx.field(converter=as_float64)
    exponent: int = eqx.field(static=True)

    @property
    def history(self) -> tuple[np.ndarray, np.ndarray]:
        """The history at rest: u = 0 and y = 0."""
        zero = np.zeros(np.broadcast_shapes(*map(np.shape, (self.stiffness, self.yield_force, self.hardening))))
        return zero, zero

    def _loaded(self, y, x):
        """The new y, after loading from y ≥ 0 by a displacement x ≥ 0 in units of u_y."""
        if self.exponent == 1:
            return y - (1 - y) * jnp.expm1(-x)
        tanh = jnp.tanh(x)
        return (y + tanh) / (1 + y * tanh)

    def __call__(self, u, v, history):
        """Force p at displacement u, and the history (u, y) after the motion to u."""
        before, y = history
        bound = self.yield_force / self.stiffness
        way = (u - before) / bound
        sign = jnp.where(way < 0, -1.0, 1.0)
        y, x = sign * y, sign * way
        # If y is negative, a first part of x unloads: y grows by this part up to zero. The rest of x loads from zero.
        unloading = jnp.minimum(y + x, 0.0)
        y = sign * (unloading + self._loaded(jnp.maximum(y, 0.0), jnp.maximum(x + jnp.minimum(y, 0.0), 0.0)))
        force = self.stiffness * (self.hardening * u + (1 - self.hardening) * bound * y)
        return force, (u, y)


@keywords_only
def bouc_wen(*, stiffness, yield_force, hardening=0.0, exponent: int = 1) -> BoucWen:
    """Smooth hysteresis: initial stiffness k, yield force p_y, ratio b of the final stiffness to k, and exponent n.

    Raises
    ------
    ValueError
        If k or p_y is not greater than zero, b is not between 0 and 1, n is neither 1 nor 2, or arrays among k, p_y
        and b differ in shape.
    """
    _check("stiffness", stiffness, 0.0, strict=True)
    _check("yield_force", yield_force, 0.0, strict=True)
    _check("hardening", hardening, 0.0, strict=False, high=1.0)
    _check_shapes(stiffness=stiffness, yield_force=yield_force, hardening=hardening)
    if not is_whole(exponent, 1) or exponent > 2:
        raise ValueError(f"exponent must be 1 or 2, for which the law has a closed solution, not {exponent!r}.")
    return BoucWen(stiffness=stiffness, yield_force=yield_force, hardening=hardening, exponent=int(exponent))


class ViscousDamper(KeywordsOnly, eqx.Module):
    """A fluid damper with the force c abs(u̇)^α sgn u̇."""

    coefficient: Any = eqx.field(converter=as_float64)
    exponent: Any = eqx.field(converter=as_float64)

    def __call__(self, u, v):
        """Force c |u̇|^α sgn u̇. For α < 1 its derivative at rest is infinite and is replaced by zero."""
        moves = v != 0
        speed = jnp.where(moves, jnp.abs(v), 1.0)
        at_rest = jnp.where(self.exponent == 1, 1.0, 0.0)
        return self.coefficient * v * jnp.where(moves, speed ** (self.exponent - 1), at_rest)


@keywords_only
def viscous_damper(*, coefficient, exponent=1.0) -> ViscousDamper:
    """A fluid damper with the force c abs(u̇)^α sgn u̇, the coefficient c and the exponent α.

    Raises
    ------
    ValueError
        If c is negative, α lies outside 0 < α ≤ 2, or both are arrays of different shapes.
    """
    _check("coefficient", coefficient, 0.0, strict=False)
    _check("exponent", exponent, 0.0, strict=True, high=2.0)
    _check_shapes(coefficient=coefficient, exponent=exponent)
    return ViscousDamper(coefficient=coefficient, exponent=exponent)


class Gap(KeywordsOnly, eqx.Module):
    """A spring that is in contact beyond the displacement g: p = k (u − g) for u > g, zero otherwise."""

    stiffness: Any = eqx.field(converter=as_float64)
    opening: Any = eqx.field(converter=as_float64)

    def __call__(self, u):
        """Force k (u − g) for u > g, zero otherwise."""
        return self.stiffness * jnp.maximum(u - self.opening, 0.0)

    def potential(self, u):
        """Stored energy ½ k (u − g)² for u > g, zero otherwise, summed over elements."""
        return jnp.sum(self.stiffness * jnp.maximum(u - self.opening, 0.0) ** 2) / 2


@keywords_only
def gap(*, stiffness, opening=0.0) -> Gap:
    """A stop of stiffness k behind an opening g; with g = 0 a unilateral spring.

    Raises
    ------
    ValueError
        If k is not greater than zero, g is not a finite number, or both are arrays of different shapes.
    """
    _check("stiffness", stiffness, 0.0, strict=True)
    _check("opening", opening, -np.inf, strict=True)
    _check_shapes(stiffness=stiffness, opening=opening)
    return Gap(stiffness=stiffness, opening=opening)


class _Elements(eqx.Module):
    """Base class for the force of the springs of one material in a structure."""

    material: Any
    elongations: Callable
    count: int = eqx.field(static=True)

    def _of(self, u):
        """The elongations, after a check of their shape."""
        elongations = self.elongations(u)
        if jnp.shape(elongations) != (self.count,):
            raise ValueError(
                f"elongations of {self.count} elements must return the shape ({self.count},), not "
                f"{jnp.shape(elongations)}."
            )
        return elongations

    def _to_nodes(self, u, forces):
        return jax.vjp(self.elongations, u)[1](forces)[0]

    def potential(self, u, *history):
        """Stored energy of all elements."""
        return self.material.potential(self._of(u), *history)


class _Elastic(_Elements):
    def __call__(self, u):
        """The nodal forces."""
        return self._to_nodes(u, self.material(self._of(u)))


class _Damping(_Elements):
    def __call__(self, u, v):
        """The nodal forces."""
        return self._to_nodes(u, self.material(*jax.jvp(self._of, (u,), (v,))))


class _WithHistory(_Elements):
    @property
    def history(self) -> Any:
        """The history of the material for every element."""
        return jax.tree.map(lambda leaf: np.broadcast_to(leaf, (self.count,)).copy(), self.material.history)

    def __call__(self, u, v, history):
        """The nodal forces and the new history."""
        forces, history = self.material(*jax.jvp(self._of, (u,), (v,)), history)
        return self._to_nodes(u, forces), history


def elements(material: Callable, elongations: Callable[[Vector], Vector], count: int) -> Any:
    """The force of springs of one material in a structure: p = (∂e/∂u)ᵀ q, with q the force of the material.

    Parameters
    ----------
    material
        A material of this module, whose parameters are numbers or arrays (count,), or your own function q(e) or
        q(e, ė). A function q(e, ė, history) needs an attribute ``history``.
    elongations
        e(u), of shape (count,), written with ``jax.numpy``.
    count
        Number of elements.

    Returns
    -------
    Callable
        A force for :class:`study.Problem` with the arguments of the material. Its ``potential`` calls the
        potential of the material. It has the ``history`` of all elements if the material has a history.

    Raises
    ------
    TypeError
        If the material or the elongations are not functions.
    ValueError
        If ``count`` is not a whole number of at least one, or the history of the material belongs to another number of
        elements; when the force is called, if the elongations have another shape.
    """
    if not is_whole(count, 1):
        raise ValueError(f"count must be a whole number of at least 1, not {count!r}.")
    for name, function in (("material", material), ("elongations", elongations)):
        if not callable(function):
            raise TypeError(f"{name} of elements must be a function, not {function!r}.")
    for start in jax.tree.leaves(getattr(material, "history", None)):
        if np.shape(start) not in ((), (count,)):
            raise ValueError(f"{count} elements need a material with numbers or arrays ({count},), not {material}.")
    kind = {1: _Elastic, 2: _Damping}.get(number_of_arguments(material), _WithHistory)
    return kind(material, elongations, int(count))
