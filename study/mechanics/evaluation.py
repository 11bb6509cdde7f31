"""A problem at a time and with a history, and its forces and energies at a displacement and a velocity."""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Self

import equinox as eqx
import jax.numpy as jnp

from study.algebra.arrays import Matrix, Scalar, ScalarLike, Vector, VectorLike
from study.algebra.counting import count
from study.algebra.matrices import times


class Evaluation(eqx.Module):
    """A problem at a time and with a history; its fields are those of :class:`study.Problem`."""

    force: eqx.AbstractVar[Callable]
    potential: eqx.AbstractVar[Callable | None]
    load: eqx.AbstractVar[Callable | None]
    history: eqx.AbstractVar[Any]
    stiffness: eqx.AbstractVar[Matrix]
    mass: eqx.AbstractVar[Matrix]
    damping: eqx.AbstractVar[Matrix]
    title: eqx.AbstractVar[str]
    _at_rest: eqx.AbstractVar[Any]
    _time: eqx.AbstractVar[Any]
    arguments: eqx.AbstractVar[int]
    place_of_time: eqx.AbstractVar[int | None]
    takes_velocity: eqx.AbstractVar[bool]

    @property
    def linear(self) -> bool:
        """Whether the internal force is K u alone."""
        return self.force is None

    @property
    def damped(self) -> bool:
        """Whether forces depend on the velocity."""
        return self.damping is not None or self.takes_velocity

    @property
    def takes_time(self) -> bool:
        """Whether the force takes the time."""
        return self.place_of_time is not None

    @property
    def dissipative(self) -> bool:
        """Whether the internal force takes a velocity, a history or the time, so that it may dissipate."""
        return self.arguments > 1 or self.takes_time

    @property
    def conservative(self) -> bool:
        """Whether the energy is constant: there is no damping, no load, and the force takes the displacement alone."""
        return self.damping is None and self.load is None and not self.dissipative

    def _changed(self, name: str, value: Any) -> Self:
        """A copy of the problem with another value of one field; the copy is not checked."""
        copy = object.__new__(type(self))
        for field in fields(self):
            if hasattr(self, field.name):  # a field is missing while the problem is made
                object.__setattr__(copy, field.name, getattr(self, field.name))
        object.__setattr__(copy, name, value)
        return copy

    def at(self, state: Any) -> Self:
        """The problem with the committed history of a state; a problem without a history is returned unchanged."""
        return self if self.history is None else self.remembering(state.history)

    def at_rest(self) -> Self:
        """The problem with its history at rest, at t = 0."""
        return (self if self.history is None else self.remembering(self._at_rest)).at_time(0.0)

    def at_time(self, t: ScalarLike) -> Self:
        """The problem with its force at the time t; a problem whose force does not take the time is unchanged."""
        return self._changed("_time", t) if self.takes_time else self

    def remembering(self, history: Any) -> Self:
        """The problem with the given history as the committed one."""
        return self._changed("history", history)

    def committed(self, u: VectorLike, v: VectorLike) -> Self:
        """The problem with the history after a motion to u and u̇; a problem without a history is returned unchanged."""
        return self if self.history is None else self.remembering(self._force_and_history(u, v)[1])

    def internal_force(self, u: VectorLike, v: VectorLike) -> Vector:
        """The force K u + p at displacement u and velocity u̇, from the committed history."""
        if self.stiffness is None:
            return self.varying_force(u, v)
        elastic = times(self.stiffness, u)
        if self.linear:
            count(forces=1)
            return elastic
        return elastic + self.varying_force(u, v)

    def static_force(self, u: VectorLike) -> Vector:
        """The force K u + p at displacement u and without velocity, from the committed history."""
        return self.internal_force(u, jnp.zeros_like(u))

    def varying_force(self, u: VectorLike, v: VectorLike) -> Vector:
        """The force p, without K u."""
        return self._force_and_history(u, v)[0]

    def _force_and_history(self, u: VectorLike, v: VectorLike) -> tuple[Vector, Any]:
        """The force p, and the history after a motion to u and u̇; None without a history."""
        return self._from(u, v, self.history) if self.history is not None else (self._from(u, v), None)

    def _from(self, *motion: Any) -> Any:
        """Value of the function of the force."""
        count(forces=1)
        given = list(motion[: self.arguments])
        if self.place_of_time is not None:
            if self._time is None:
                raise RuntimeError("the force takes the time, which problem.at_time(t) must state.")
            given.insert(self.place_of_time, self._time)
        return self.force(*given)

    def momentum(self, v: VectorLike) -> Vector:
        """M u̇."""
        return v if self.mass is None else times(self.mass, v)

    def energy(self, u: VectorLike, v: VectorLike) -> Scalar:
        """Kinetic and potential energy ½ u̇ᵀ M u̇ + ½ uᵀ K u + V, the scalar E of Xie (1996), eqs (4) and (5)."""
        return 0.5 * jnp.vdot(v, self.momentum(v)) + self.stored_energy(u)

    def stored_energy(self, u: VectorLike) -> Scalar:
        """½ uᵀ K u + V at displacement u, with the committed history."""
        if self.potential is None:
            raise ValueError("the energy of a problem needs its potential: give Problem(potential=...).")
        stored = self.potential(u) if self.history is None else self.potential(u, self.history)
        return stored if self.stiffness is None else stored + 0.5 * jnp.vdot(u, times(self.stiffness, u))
