"""The base classes of time integration schemes: frozen parameters with a start and a step."""

import abc
import inspect
import math
import textwrap
from dataclasses import fields
from typing import Any, ClassVar

import equinox as eqx
import jax
import numpy as np

from study.algebra.arrays import ScalarLike, Vector
from study.algebra.scalars import is_number
from study.keywords import KeywordsOnly
from study.mechanics.balance import initial_acceleration
from study.mechanics.definition import Problem
from study.mechanics.state import Effort, Motion
from study.scheme.contract import incremented
from study.warn import warn
from study.words import listed


class Scheme(KeywordsOnly, eqx.Module):
    """A time integration scheme for M ü + C u̇ + p(u) = f(t).

    A scheme carries its own state from step to step, with at least the fields ``u`` and ``v``.
    :class:`study.mechanics.state.Motion` also has the acceleration; the state of a multi-step scheme also has values of
    earlier steps. :meth:`start` and :meth:`step` are pure functions, so that JAX can compile, vectorise and
    differentiate them. Parameters are given by name, in classes that you derive too.

    Warns
    -----
    RuntimeWarning
        If the parameters make a ``stability_limit`` that is computed from them zero: the amplitude of free vibration
        then grows, however small the step. A limit that a class or an argument states is not warned about.

    Raises
    ------
    TypeError
        If a parameter is given without its name, or the class does not define a name that is abstract here.
    """

    #: Name of the scheme in figures and tables.
    title: eqx.AbstractVar[str]
    #: Family of the scheme; schemes of one family share a panel in figures.
    family: ClassVar[str]

    @property
    @abc.abstractmethod
    def source(self) -> str:
        """Author and year of the first publication."""

    @property
    @abc.abstractmethod
    def doi(self) -> str:
        """Digital object identifier of the source, empty if it has none."""

    @property
    @abc.abstractmethod
    def order(self) -> int:
        """Order of accuracy of the displacement in Δt, for free motion without damping."""

    @property
    def order_with_damping(self) -> int:
        """Order of accuracy with damping, a velocity-dependent force or a load; the lowest of the three orders."""
        return self.order

    @property
    def stability_limit(self) -> float | None:
        """Largest ωΔt at which the scheme is stable without damping; infinite if always stable, zero if never stable.

        None if the limit is not known for these parameters; :meth:`study.LinearTheory.stability_limit` computes it.
        """
        return None

    @property
    @abc.abstractmethod
    def explicit(self) -> bool:
        """Whether a step needs no iteration, even if the internal force is non-linear.

        If the internal force depends on the velocity, an explicit scheme that takes the new velocity in its balance of
        forces still iterates.
        """

    @property
    def keeps_energy(self) -> bool:
        """Whether the energy error of free vibration without damping does not grow with the number of periods.

        Symplectic, symmetric and energy-conserving schemes keep it. Schemes that do not state it count as dissipative.
        """
        return False

    @property
    def order_of_loss(self) -> float:
        """Power of Δt with which free vibration without damping loses energy over time; infinite if it loses none.

        Terms of even power in the modified equation are reversible in time, and cause no loss. The power is therefore
        the smallest odd number from ``order`` on, unless a scheme states another.
        """
        return math.inf if self.keeps_energy else self.order + 1 - self.order % 2

    @property
    def is_exact_for_stiffness(self) -> bool:
        """Whether the stiffness K of a problem is integrated exactly, so that it sets no limit to the step."""
        return False

    @property
    def needs_equal_steps(self) -> bool:
        """Whether all steps must have one size, because the values that the scheme carries depend on this size."""
        return True

    @property
    def acceleration_offset(self) -> float | None:
        """Time of the carried acceleration ``a`` minus the end of the step, in units of the step size.

        None if the scheme carries no acceleration, or does not state its time.
        """
        return None

    @property
    def force_at_end(self) -> bool:
        """Whether the state after a step depends on the internal force at the end of the step or a prediction of it.

        If not, a step may end in a contact that no force of the step has met. Runs with a tolerance then evaluate the
        force at the end of each step in addition (:class:`study.control.end_of_step.WithEnd`).
        """
        return False

    @property
    def needs_mass(self) -> bool:
        """Whether every unknown must have mass.

        An unknown without mass is a mode of infinite frequency. A scheme can step it if the scheme never solves with M
        alone, and if no eigenvalue of its amplification matrix at infinite frequency exceeds one in size. By default
        explicit schemes need mass and implicit schemes do not. An implicit scheme that cannot step a mode of infinite
        frequency overrides this property.
        """
        return self.explicit

    def __new__(cls, *positional, **named):
        """A new scheme, unless its class lacks a definition."""
        if missing := sorted(cls.__abstractmethods__ | cls.__abstractvars__):  # type: ignore[attr-defined]
            purposes = {name: (getattr(cls, name, None).__doc__ or "").partition(".")[0] for name in missing}
            lacks = listed(f"{name} ({purpose})" if purpose else name for name, purpose in purposes.items())
            raise TypeError(f"{cls.__name__} is a scheme and must define {lacks}.")
        return super().__new__(cls, *positional, **named)

    def __check_init__(self):
        if isinstance(self, Wrapper) or any(isinstance(x, jax.core.Tracer) for x in jax.tree.leaves(self)):
            return
        computed = isinstance(inspect.getattr_static(type(self), "stability_limit"), property)
        if computed and self.stability_limit == 0:
            warn(
                f"{type(self).__name__}({self._parameters()}) has negative numerical damping: without physical damping "
                "the amplitude grows, however small the step."
            )

    def _parameters(self) -> str:
        """The parameters as they are given, without labels."""
        names = [
            field.name for field in fields(self) if field.name not in ("title", "source", "doi", "stability_limit")
        ]
        return ", ".join(f"{name}={_short(getattr(self, name))}" for name in names)

    def __repr__(self) -> str:
        kind, summary = type(self).__name__, (type(self).__doc__ or "").partition("\n")[0]
        least = self.order_with_damping
        damped = f" (at least {least} with damping or load)" if least < self.order else ""
        named = {None: "", 0.0: ", unstable without damping", np.inf: ", unconditionally stable for linear systems"}
        limit = self.stability_limit
        stable = named[limit] if limit in named else f", stable for ωΔt ≤ {limit:.4g}"
        lines = [
            # a dataclass without a docstring gets its signature as docstring
            self.title if summary.startswith(f"{kind}(") else f"{self.title}: {summary}",
            textwrap.shorten(f"{kind}({self._parameters()})", 120, placeholder=" ...)"),
            f"{'explicit' if self.explicit else 'implicit'}, order {self.order}{damped}{stable}",
            f"source: {self.source}",
        ]
        return "\n".join(lines)

    def refusal(self, problem: Problem) -> str | None:
        """One sentence on why the scheme cannot step this problem; None if it can."""
        if problem.massless and self.needs_mass:
            return (
                f"'{self.title}' needs a mass at every unknown, and the mass of '{problem.title}' is singular: take an "
                "implicit scheme that is unconditionally stable, or give every unknown a mass."
            )
        return None

    @abc.abstractmethod
    def start(self, problem: Problem, u0: Vector, v0: Vector, dt: ScalarLike) -> tuple[Any, Effort]:
        """State at t = 0, and the effort to find it."""

    @abc.abstractmethod
    def step(self, problem: Problem, state: Any, t: ScalarLike, dt: ScalarLike) -> tuple[Any, Effort]:
        """State at t + Δt from the state at t, and the effort of the step."""


class OneStep(Scheme):
    """A scheme whose step adds increments to u and u̇, so that the round-off of these sums can be compensated."""

    needs_equal_steps = False

    def start(self, problem: Problem, u0: Vector, v0: Vector, dt: ScalarLike) -> tuple[Any, Effort]:
        """State at t = 0 with the acceleration from the equation of motion, and an effort of zero."""
        return Motion(u0, v0, initial_acceleration(problem, u0, v0)), Effort()

    @abc.abstractmethod
    def increment(self, problem: Problem, state: Any, t: ScalarLike, dt: ScalarLike) -> tuple[Any, Effort]:
        """State at t + Δt with the increments of u and v in place of u and v, and the effort of the step."""

    def step(self, problem, state, t, dt):
        new, effort = incremented(self, problem, state, t, dt)
        return new._replace(u=state.u + new.u, v=state.v + new.v), effort


class WrapperState(eqx.Module):
    """State of a wrapper: the state of the wrapped scheme, ``inner``, and additional fields."""

    inner: eqx.AbstractVar[Any]

    @property
    def u(self) -> Vector:
        """Displacement."""
        return self.inner.u

    @property
    def v(self) -> Vector:
        """Velocity."""
        return self.inner.v


class Wrapper(Scheme):
    """A scheme that steps another scheme, ``scheme``, and extends or changes the state of this scheme."""

    scheme: eqx.AbstractVar[Scheme]

    @property
    def order(self) -> int:
        return self.scheme.order

    @property
    def order_with_damping(self) -> int:
        return self.scheme.order_with_damping

    @property
    def stability_limit(self) -> float | None:
        return self.scheme.stability_limit

    @property
    def explicit(self) -> bool:
        return self.scheme.explicit

    @property
    def keeps_energy(self) -> bool:
        return self.scheme.keeps_energy

    @property
    def order_of_loss(self) -> float:
        return self.scheme.order_of_loss

    @property
    def is_exact_for_stiffness(self) -> bool:
        return self.scheme.is_exact_for_stiffness

    @property
    def needs_equal_steps(self) -> bool:
        return self.scheme.needs_equal_steps

    @property
    def acceleration_offset(self) -> float | None:
        return self.scheme.acceleration_offset

    @property
    def force_at_end(self) -> bool:
        return self.scheme.force_at_end

    @property
    def needs_mass(self) -> bool:
        return self.scheme.needs_mass

    def refusal(self, problem: Problem) -> str | None:
        return self.scheme.refusal(problem) or super().refusal(problem)


def _short(value: Any) -> str:
    """Text of a parameter, with numbers to six digits."""
    if isinstance(value, Scheme):
        return value.title
    if isinstance(value, tuple):
        return f"({', '.join(map(_short, value))})"
    return f"{value:.6g}" if isinstance(value, float) else repr(value)


def as_tuple(values):
    """A list as a tuple; anything else unchanged."""
    return tuple(values) if isinstance(values, list) else values


def check_numbers(scheme: str, name: str, values) -> None:
    """Refuse values that are not a tuple of one or more finite numbers."""
    if not isinstance(values, tuple) or not values or not all(is_number(v) and np.isfinite(v) for v in values):
        raise ValueError(f"{scheme}({name}={values!r}): {name} must be a tuple of finite numbers.")


def check_range(scheme: str, name: str, value, low: float, high: float) -> None:
    """Refuse a parameter that is not a finite number within [low, high]; a traced parameter cannot be checked."""
    if isinstance(value, jax.core.Tracer):
        return
    limits = f"at least {low:g}" if np.isinf(high) else f"between {low:g} and {high:g}"
    single = np.ndim(value) == 0 and np.asarray(value).dtype.kind in "fiu"
    if not single or not np.isfinite(value) or not low <= value <= high:
        raise ValueError(f"{scheme}({name}={value}): {name} must be a number {limits}.")


def check_ranges(module: eqx.Module, **ranges: tuple[float, float]) -> None:
    """Refuse a scheme or a controller that has a field outside the range [low, high] of the field."""
    for name, (low, high) in ranges.items():
        check_range(type(module).__name__, name, getattr(module, name), low, high)
