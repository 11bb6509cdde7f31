"""The interface of observers."""

import abc
from typing import Any, ClassVar

import equinox as eqx

from study.mechanics.definition import Problem
from study.mechanics.state import Effort


class Observer(eqx.Module):
    """A quantity to observe during a run: a :class:`Reduction` or a :class:`Record`."""

    #: Attributes ``long_name`` and ``units`` of each variable that the observer returns, by the variable's name.
    variables: ClassVar[dict[str, dict[str, str]]]
    #: Whether the problem must have a potential.
    needs_energy: ClassVar[bool] = False
    #: Whether the problem must have positions.
    needs_positions: ClassVar[bool] = False
    #: Whether the problem must have ground motion.
    needs_ground: ClassVar[bool] = False
    #: Whether all steps must have one size.
    needs_equal_steps: ClassVar[bool] = False
    #: Whether the run must carry a perturbed motion, as :class:`study.scheme.wrapper.linearised.Linearised` does.
    needs_neighbour: ClassVar[bool] = False

    def marched(self) -> "Observer":
        """The reduction or record that a march runs for this observer; by default the observer itself."""
        return self

    def refusal(self, problem: Problem) -> str | None:
        """One sentence on why the problem cannot be observed; None if it can."""
        for is_needed, argument in (
            (self.needs_energy, "potential"),
            (self.needs_positions, "positions"),
            (self.needs_ground, "ground"),
        ):
            if is_needed and getattr(problem, argument) is None:
                names = ", ".join(self.variables)
                return f"{names} of '{problem.title}' needs Problem({argument}=...), which it was made without."
        return None


class Reduction(Observer):
    """A quantity with one value per run, which is updated with every step.

    The three methods are pure functions that JAX compiles into the march. A state has at least the fields ``u`` and
    ``v``, each of shape () or (n,).
    """

    @abc.abstractmethod
    def start(self, problem: Problem, state: Any) -> Any:
        """State of the reduction at t = 0: any arrays, whose shapes and types stay the same."""

    def started(self, carried: Any, effort: Effort) -> Any:
        """State of the reduction after the start of the scheme, which took the given effort; unchanged by default."""
        return carried

    @abc.abstractmethod
    def update(self, carried: Any, problem: Problem, state: Any, t: Any, effort: Effort) -> Any:
        """State of the reduction after a step of the given effort, which ends with ``state`` at the time ``t``."""

    @abc.abstractmethod
    def result(self, carried: Any, problem: Problem, state: Any) -> dict[str, Any]:
        """Values of ``variables`` at the end of the run; ``state`` is the last state of the motion."""


class Record(Observer):
    """A quantity whose values are stored along time."""

    @abc.abstractmethod
    def sample(self, problem: Problem, initial: Any, state: Any, t: Any) -> dict[str, Any]:
        """Values of ``variables`` for the state at the time ``t``; ``initial`` is the state at t = 0."""
