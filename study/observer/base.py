"""What an observer is."""

import abc
from typing import Any, ClassVar

import equinox as eqx

from study.equilibrium.state import Effort
from study.problem.definition import Problem


class Observer(eqx.Module):
    """Something to know of a run: a :class:`Reduction` gives one value a run, a :class:`Record` one value a sample."""

    #: Attributes of the variables that the observer gives, by the variables' names.
    variables: ClassVar[dict[str, dict[str, str]]]
    #: Whether the problem must have a potential, or positions.
    needs_energy: ClassVar[bool] = False
    needs_positions: ClassVar[bool] = False
    #: Whether the run must have a neighbour along (:class:`study.schemes.Linearised`).
    needs_neighbour: ClassVar[bool] = False

    def lacking(self, problem: Problem) -> str | None:
        """The argument of :class:`Problem` that the observer needs and the problem was made without."""
        if self.needs_energy and problem.potential is None:
            return "potential"
        if self.needs_positions and problem.positions is None:
            return "positions"
        return None


class Reduction(Observer):
    """A value that is updated with every step."""

    @abc.abstractmethod
    def start(self, problem: Problem, state) -> Any:
        """What is carried along, at t = 0."""

    @abc.abstractmethod
    def update(self, carried, problem: Problem, state, t, effort: Effort) -> Any:
        """What is carried along, one step later, at the time ``t``."""

    @abc.abstractmethod
    def result(self, carried, problem: Problem, state) -> dict[str, Any]:
        """The values of ``variables`` at the end of the run, where ``state`` is the last one."""


class Record(Observer):
    """Values that are stored along time."""

    @abc.abstractmethod
    def sample(self, problem: Problem, initial, state) -> dict[str, Any]:
        """The values of ``variables`` at one time."""
