"""What a time integration scheme is: a frozen set of parameters with a start and a step."""

import abc
from typing import Any, ClassVar

import equinox as eqx
import jax
import numpy as np

from study.equilibrium.balance import initial_acceleration
from study.equilibrium.state import Effort, Motion
from study.problem.definition import Problem


class Scheme(eqx.Module):
    """A time integration scheme for M ü + C u̇ + p(u) = f(t).

    A scheme carries its own state from step to step, anything with the fields ``u`` and ``v`` (:class:`Motion` adds
    the acceleration; a multi-step scheme adds its history). Both functions are pure, so that JAX can compile,
    vectorise and differentiate them.
    """

    #: What figures and tables call it.
    title: eqx.AbstractVar[str]
    #: Schemes of one family share the panels of figures.
    family: ClassVar[str]

    @property
    @abc.abstractmethod
    def source(self) -> str:
        """Who published it first, and when."""

    @property
    @abc.abstractmethod
    def doi(self) -> str:
        """Digital object identifier of the source, empty where it has none."""

    @property
    @abc.abstractmethod
    def order(self) -> int:
        """Order of accuracy of the displacement in Δt, of a free motion without damping."""

    @property
    def damped_order(self) -> int:
        """Order of accuracy where there is damping or a load, the lower of both."""
        return self.order

    @property
    @abc.abstractmethod
    def explicit(self) -> bool:
        """Whether a step needs no iteration, however non-linear the internal force."""

    @property
    def evaluations(self) -> int:
        """Internal forces that a step evaluates beside those of its Newton iterations."""
        return 0

    @property
    def evaluations_per_iteration(self) -> int:
        """Internal forces that one Newton iteration evaluates."""
        return 1

    @property
    def needs_mass(self) -> bool:
        """Whether no unknown may be massless: a step solves with M alone, or is stable up to some frequency only."""
        return self.explicit

    @abc.abstractmethod
    def start(self, problem: Problem, u0, v0, dt) -> tuple[Any, Effort]:
        """State at t = 0, and what it took."""

    @abc.abstractmethod
    def step(self, problem: Problem, state, t, dt) -> tuple[Any, Effort]:
        """State at t + Δt from the state at t, and what it took."""


class OneStep(Scheme):
    """A scheme whose step adds to displacement and velocity, so that these sums can be compensated."""

    @abc.abstractmethod
    def increment(self, problem: Problem, state, t, dt) -> tuple[Any, Effort]:
        """State at t + Δt with the increments of u and v in their places, and what it took."""

    def step(self, problem, state, t, dt):
        new, effort = self.increment(problem, state, t, dt)
        return new._replace(u=state.u + new.u, v=state.v + new.v), effort


class Wrapper(Scheme):
    """A scheme that steps another one, ``scheme``, and carries something beside its state."""

    scheme: eqx.AbstractVar[Scheme]

    @property
    def order(self) -> int:
        return self.scheme.order

    @property
    def damped_order(self) -> int:
        return self.scheme.damped_order

    @property
    def explicit(self) -> bool:
        return self.scheme.explicit

    @property
    def evaluations(self) -> int:
        return self.scheme.evaluations

    @property
    def evaluations_per_iteration(self) -> int:
        return self.scheme.evaluations_per_iteration

    @property
    def needs_mass(self) -> bool:
        return self.scheme.needs_mass


def start_in_balance(self, problem: Problem, u0, v0, dt) -> tuple[Motion, Effort]:
    """State at t = 0 with the acceleration that the equation of motion gives there."""
    return Motion(u0, v0, initial_acceleration(problem, u0, v0)), Effort()


def as_tuple(values):
    """A tuple of a list, whatever else as it is."""
    return tuple(values) if isinstance(values, list) else values


def check_numbers(scheme: str, name: str, values) -> None:
    """Refuse what is no tuple of finite numbers."""
    if (
        not isinstance(values, tuple)
        or not values
        or not all(isinstance(v, int | float) and not isinstance(v, bool) and np.isfinite(v) for v in values)
    ):
        raise ValueError(f"{scheme}({name}={values!r}): {name} must be a tuple of finite numbers.")


def check_range(scheme: str, name: str, value, low: float, high: float) -> None:
    """Refuse a parameter that is no finite number within [low, high]; a traced one cannot be checked."""
    if isinstance(value, jax.core.Tracer):
        return
    limits = f"at least {low:g}" if np.isinf(high) else f"between {low:g} and {high:g}"
    is_number = np.ndim(value) == 0 and np.asarray(value).dtype.kind in "fiu"
    if not is_number or not np.isfinite(value) or not low <= value <= high:
        raise ValueError(f"{scheme}({name}={value}): {name} must be a number {limits}.")


def check_ranges(scheme: Scheme, **ranges: tuple[float, float]) -> None:
    """Refuse a scheme with a field that is out of its (low, high)."""
    for name, (low, high) in ranges.items():
        check_range(type(scheme).__name__, name, getattr(scheme, name), low, high)
